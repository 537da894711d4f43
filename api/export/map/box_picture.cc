#include <algorithm>
#include <cmath>

#include "api/export/color_ramp.h"
#include "api/export/jpeg.h"
#include "api/export/map/map_picture.h"
#include "api/export/map/outline.h"
#include "api/export/png.h"

namespace freelsd {
namespace {

// Distance between two lines of the hatch, as a share of the picture's longer side.
constexpr double kHatchShare = 0.008;

PixelPlaces PlacesOf(const WorldBox& box, double pixel_size_m, const LocalFrame& local_frame) {
  CheckExtent(box);
  const Eigen::Array2d size_m = box.max_in_world - box.min_in_world;
  const Eigen::Array2d size_px = (size_m / pixel_size_m).round().max(1.0);
  const Eigen::Array2d step_m = size_m / size_px;
  const double west = box.min_in_world.x(), north = box.max_in_world.y();
  const auto geo = [=, &local_frame](const Eigen::Vector2d& position) {
    return local_frame.GeoFromWorld(
        {west + step_m.x() * position.x(), north - step_m.y() * position.y(), 0.0});
  };
  const cv::Rect pixels(0, 0, static_cast<int>(size_px.x()), static_cast<int>(size_px.y()));
  return {{geo, step_m.maxCoeff()}, pixels, local_frame};
}

enum HazardIndex : uint8_t {
  kClearIndex,
  kFreeIndex,
  kHazardIndex,
  kHazardLineIndex,
  kUnseenIndex,
  kUnseenLineIndex,
};

cv::Vec4b Translucent(const Color& color, uint8_t alpha) {
  return {color[2], color[1], color[0], alpha};
}

Palette HazardPalette(Backdrop backdrop) {
  const bool is_alone = backdrop == Backdrop::kNone;
  Palette palette{};
  palette[kFreeIndex] = Translucent(kFreeColor, is_alone ? 255 : 70);
  palette[kHazardIndex] = Translucent(kHazardColor, is_alone ? 255 : 105);
  palette[kHazardLineIndex] = Translucent(Color(110, 35, 0), is_alone ? 255 : 170);
  palette[kUnseenIndex] = Translucent(Color(230, 230, 230), is_alone ? 255 : 110);
  palette[kUnseenLineIndex] = Translucent(Color(110, 110, 110), is_alone ? 255 : 200);
  return palette;
}

// Lines rise to the east over unseen ground, and fall, less dense, over hazard.
HazardIndex IndexAt(uint8_t state, int row, int col, int period_px) {
  const int line_px = (period_px + 2) / 4;
  if (state == kFree) return kFreeIndex;
  if (state == Safety::kOutside) return kClearIndex;
  if (state == kHazard) {
    const int period = 2 * period_px;
    const bool is_line = ((row - col) % period + period) % period < line_px;
    return is_line ? kHazardLineIndex : kHazardIndex;
  }
  return (row + col) % period_px < line_px ? kUnseenLineIndex : kUnseenIndex;
}

}  // namespace

std::string PhotoBoxJpeg(const WorldBox& box,
                         double pixel_size_m,
                         const std::vector<PhotoWindow>& windows,
                         const LocalFrame& local_frame) {
  return EncodeJpeg(PhotoPicture(PlacesOf(box, pixel_size_m, local_frame), windows));
}

std::string HazardBoxPng(const WorldBox& box,
                         double pixel_size_m,
                         const std::vector<MapWindow>& windows,
                         Backdrop backdrop,
                         const LocalFrame& local_frame) {
  const PixelPlaces places = PlacesOf(box, pixel_size_m, local_frame);
  const cv::Mat1b state = SafetyOf(places, windows, MapLayer::kHazard).state;
  const int period_px =
      std::max(4, static_cast<int>(std::lround(kHatchShare * std::max(state.rows, state.cols))));
  cv::Mat1b indices(state.size(), kClearIndex);
  for (int row = 0; row < state.rows; ++row) {
    for (int col = 0; col < state.cols; ++col) {
      indices(row, col) = IndexAt(state(row, col), row, col, period_px);
    }
  }
  return EncodePalettePng(indices, HazardPalette(backdrop));
}

std::string LayerBoxPng(const std::string& layer,
                        const WorldBox& box,
                        double pixel_size_m,
                        const std::vector<MapWindow>& windows,
                        const Scale& scale,
                        const LocalFrame& local_frame) {
  CheckScale(scale);
  const PixelPlaces places = PlacesOf(box, pixel_size_m, local_frame);
  return EncodePalettePng(IndicesOf(ValueLayerOf(layer), places, windows, scale), PaletteOf(layer));
}

}  // namespace freelsd
