#include <algorithm>
#include <cmath>

#include "api/export/jpeg.h"
#include "api/export/map/map_picture.h"
#include "api/export/map/outline.h"
#include "api/export/map/web_mercator.h"
#include "api/export/png.h"

namespace freelsd {
namespace {

// Of the windows' outlines, for their edges between the projected places.
constexpr double kOutlineMarginPx = 2.0;

const Grid& GridOf(const MapWindow& window) { return window.site_map.map.grid; }
const Grid& GridOf(const PhotoWindow& window) { return window.grid; }

PictureFrame FrameOf(const XyzTile& tile, const LocalFrame& local_frame) {
  const Eigen::Vector2d corner = Eigen::Vector2d(tile.x, tile.y) * kTileSizePx;
  return {[=](const Eigen::Vector2d& position) { return GeoFromPixel(corner + position, tile.z); },
          PixelSizeM(tile.z, local_frame.origin().latitude_deg)};
}

// Box around the grid in pixels from the tile's corner; it may reach beyond the world's edges.
Eigen::AlignedBox2d OutlinePx(const Grid& grid, const XyzTile& tile, const LocalFrame& frame) {
  const std::vector<Eigen::Vector2d> corners = OuterCorners(grid);
  Eigen::AlignedBox2d box;
  for (const GeoPoint& place : OutlineOf({corners[3], corners[1]}, frame)) {
    box.extend(PixelFromGeo(place, tile.z) - Eigen::Vector2d(tile.x, tile.y) * kTileSizePx);
  }
  return box;
}

cv::Rect InTile(const Eigen::AlignedBox2d& box) {
  constexpr double kSize = kTileSizePx;
  const Eigen::Array2d low = (box.min().array() - kOutlineMarginPx).floor().max(0.0).min(kSize);
  const Eigen::Array2d high = (box.max().array() + kOutlineMarginPx).ceil().max(0.0).min(kSize);
  return {cv::Point(static_cast<int>(low.x()), static_cast<int>(low.y())),
          cv::Point(static_cast<int>(high.x()), static_cast<int>(high.y()))};
}

// Boxes of the tile's pixels that may show a window. The world repeats itself from west to east, so
// a tile of the whole world may hold a map at two of its edges.
template <typename Window>
std::vector<cv::Rect> BoxesOf(const XyzTile& tile,
                              const std::vector<Window>& windows,
                              const LocalFrame& frame) {
  std::vector<cv::Rect> boxes;
  if (windows.empty()) return boxes;
  Eigen::AlignedBox2d outline;
  for (const Window& window : windows) outline.extend(OutlinePx(GridOf(window), tile, frame));
  for (const double turn : {-1.0, 0.0, 1.0}) {
    const Eigen::Vector2d shift(turn * WorldSizePx(tile.z), 0.0);
    const cv::Rect box = InTile({outline.min() + shift, outline.max() + shift});
    if (!box.empty()) boxes.push_back(box);
  }
  return boxes;
}

cv::Mat4b PhotoTile(const XyzTile& tile,
                    const std::vector<PhotoWindow>& windows,
                    const LocalFrame& local_frame) {
  tile.Check();
  cv::Mat4b picture(kTileSizePx, kTileSizePx, cv::Vec4b(0, 0, 0, 0));
  for (const cv::Rect& box : BoxesOf(tile, windows, local_frame)) {
    PhotoPicture({FrameOf(tile, local_frame), box, local_frame}, windows).copyTo(picture(box));
  }
  return picture;
}

}  // namespace

std::string MapTilePng(const std::string& layer,
                       const XyzTile& tile,
                       const std::vector<MapWindow>& windows,
                       const Scale& scale,
                       const LocalFrame& local_frame) {
  tile.Check();
  const MapLayer map_layer = ValueLayerOf(layer);
  CheckScale(scale);
  const cv::Size size(kTileSizePx, kTileSizePx);
  cv::Mat4b pixels(size, cv::Vec4b(0, 0, 0, 0));
  cv::Mat1b indices(size, 0);
  for (const cv::Rect& box : BoxesOf(tile, windows, local_frame)) {
    const PixelPlaces places(FrameOf(tile, local_frame), box, local_frame);
    if (map_layer == MapLayer::kElevation) {
      ElevationPicture(places, windows, scale, local_frame).copyTo(pixels(box));
    } else {
      IndicesOf(map_layer, places, windows, scale).copyTo(indices(box));
    }
  }
  if (map_layer == MapLayer::kElevation) return EncodePngQuickly(pixels);
  return EncodePalettePng(indices, PaletteOf(layer));
}

std::string PhotoTilePng(const XyzTile& tile,
                         const std::vector<PhotoWindow>& windows,
                         const LocalFrame& local_frame) {
  return EncodePngQuickly(PhotoTile(tile, windows, local_frame));
}

std::string PhotoTileJpeg(const XyzTile& tile,
                          const std::vector<PhotoWindow>& windows,
                          const LocalFrame& local_frame) {
  return EncodeJpeg(PhotoTile(tile, windows, local_frame));
}

}  // namespace freelsd
