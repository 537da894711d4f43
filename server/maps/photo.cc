#include <algorithm>
#include <cmath>

#include <spdlog/spdlog.h>

#include "server/maps/maps.h"

namespace freelsd {
namespace {

constexpr size_t kBytesPerMissingPhoto = 256;

// Empty if the bytes are no picture of this size.
cv::Mat4b Decoded(const std::string& bytes, int side_px, const std::string& file) {
  try {
    cv::Mat4b picture = DeserializePhotoTile(bytes);
    if (picture.size() == cv::Size(side_px, side_px)) return picture;
    spdlog::error("picture {} has another size than its map says", file);
  } catch (const DamagedMap& error) {
    spdlog::error("picture {}: {}", file, error.what());
  }
  return {};
}

}  // namespace

std::vector<PhotoWindow> FlightMaps::ReadPhoto(const Storage& storage,
                                               const FlightMap& map,
                                               int level,
                                               const WorldBox& box) {
  std::vector<PhotoWindow> windows;
  if (!map.head.photo) return windows;
  const PhotoLattice& lattice = *map.head.photo;
  const double side = std::ldexp(lattice.pixel_size_m, level) * lattice.tile_size_px;
  const auto index_of = [side](double metres) {
    return static_cast<int>(std::floor(metres / side));
  };
  for (int row = index_of(-box.max_in_world.y()); row <= index_of(-box.min_in_world.y()); ++row) {
    for (int col = index_of(box.min_in_world.x()); col <= index_of(box.max_in_world.x()); ++col) {
      const MapTileIndex index{level, row, col};
      cv::Mat4b pixels = PhotoAt(storage, map, index);
      if (!pixels.empty()) windows.push_back({lattice.GridOf(index), std::move(pixels)});
    }
  }
  return windows;
}

cv::Mat4b FlightMaps::PhotoAt(const Storage& storage,
                              const FlightMap& map,
                              const MapTileIndex& index) {
  const Key key{map.row.id, index};
  {
    const std::lock_guard lock(mutex_);
    if (const cv::Mat4b* const found = photos_.Find(key)) return *found;
  }
  cv::Mat4b picture;
  if (const auto sha256 =
          storage.maps.FindPhotoTile(map.row.id, {index.level, index.row, index.col})) {
    const std::optional<std::string> bytes = storage.images.Read(*sha256);
    if (bytes) picture = Decoded(*bytes, map.head.photo->tile_size_px, *sha256);
  }
  const std::lock_guard lock(mutex_);
  photos_.Keep(key, picture, picture.empty() ? kBytesPerMissingPhoto : picture.total() * 4);
  return picture;
}

}  // namespace freelsd
