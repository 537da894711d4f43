#include <algorithm>
#include <cmath>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <spdlog/spdlog.h>

#include "server/maps/maps.h"

namespace freelsd {
namespace {

constexpr size_t kBytesPerMissingPhoto = 256;
constexpr int kQuality = 88;

// Empty if the bytes are no picture.
cv::Mat4b Decoded(const std::string& bytes) {
  const cv::Mat picture =
      cv::imdecode(std::vector<uchar>(bytes.begin(), bytes.end()), cv::IMREAD_UNCHANGED);
  cv::Mat4b with_alpha;
  if (picture.type() == CV_8UC4) return picture;
  if (picture.type() == CV_8UC3) cv::cvtColor(picture, with_alpha, cv::COLOR_BGR2BGRA);
  return with_alpha;
}

bool IsOpaque(const cv::Mat4b& picture) {
  return std::all_of(
      picture.begin(), picture.end(), [](const cv::Vec4b& pixel) { return pixel[3] == 255; });
}

}  // namespace

std::string EncodePhotoTile(const cv::Mat4b& picture) {
  std::vector<uchar> bytes;
  // WebP is smaller and knows transparency, but takes longer to read.
  if (IsOpaque(picture)) {
    cv::Mat3b colors;
    cv::cvtColor(picture, colors, cv::COLOR_BGRA2BGR);
    cv::imencode(".jpg", colors, bytes, {cv::IMWRITE_JPEG_QUALITY, kQuality});
  } else {
    cv::imencode(".webp", picture, bytes, {cv::IMWRITE_WEBP_QUALITY, kQuality});
  }
  return {bytes.begin(), bytes.end()};
}

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
  const int side_px = map.head.photo->tile_size_px;
  if (const auto sha256 =
          storage.maps.FindPhotoTile(map.row.id, {index.level, index.row, index.col})) {
    const std::optional<std::string> bytes = storage.images.Read(*sha256);
    if (bytes) picture = Decoded(*bytes);
    if (picture.size() != cv::Size(side_px, side_px)) {
      spdlog::error("picture {} of map {} cannot be read", *sha256, map.row.id);
      picture = cv::Mat4b();
    }
  }
  const std::lock_guard lock(mutex_);
  photos_.Keep(key, picture, picture.empty() ? kBytesPerMissingPhoto : picture.total() * 4);
  return picture;
}

}  // namespace freelsd
