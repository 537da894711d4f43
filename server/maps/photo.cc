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

WorldBox BoxOfGrid(const Grid& grid) {
  const Eigen::Vector2d size = grid.cell_size_m * Eigen::Vector2d(grid.num_cols, grid.num_rows);
  const Eigen::Vector2d& corner = grid.north_west_in_world;
  return {{corner.x(), corner.y() - size.y()}, {corner.x() + size.x(), corner.y()}};
}

// A web map tile of the whole world is much larger than the map: without the map's box, millions of
// tiles that no map has would be looked up.
cv::Rect PhotoTilesIn(const FlightMap& map, int level, const WorldBox& box) {
  if (!map.head.photo) return {};
  const WorldBox of_map = BoxOfGrid(map.head.grid);
  const Eigen::Array2d low = box.min_in_world.cwiseMax(of_map.min_in_world);
  const Eigen::Array2d high = box.max_in_world.cwiseMin(of_map.max_in_world);
  if (!(low <= high).all()) return {};
  const double side =
      std::ldexp(map.head.photo->pixel_size_m, level) * map.head.photo->tile_size_px;
  const auto index_of = [side](double metres) {
    return static_cast<int>(std::floor(metres / side));
  };
  return {cv::Point(index_of(low.x()), index_of(-high.y())),
          cv::Point(index_of(high.x()) + 1, index_of(-low.y()) + 1)};
}

std::vector<PhotoWindow> FlightMaps::ReadPhoto(const Storage& storage,
                                               const FlightMap& map,
                                               int level,
                                               const WorldBox& box) {
  std::vector<PhotoWindow> windows;
  const cv::Rect tiles = PhotoTilesIn(map, level, box);
  for (int row = tiles.y; row < tiles.y + tiles.height; ++row) {
    for (int col = tiles.x; col < tiles.x + tiles.width; ++col) {
      const MapTileIndex index{level, row, col};
      cv::Mat4b pixels = PhotoAt(storage, map, index);
      if (!pixels.empty()) windows.push_back({map.head.photo->GridOf(index), std::move(pixels)});
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
