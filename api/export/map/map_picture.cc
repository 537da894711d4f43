#include "api/export/map/map_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "api/export/color_ramp.h"
#include "api/export/hillshade.h"

namespace freelsd {
namespace {

constexpr float kNoData = std::numeric_limits<float>::quiet_NaN();
constexpr uint8_t kTransparentIndex = 0;
constexpr uint8_t kHazardIndex = 1;
constexpr uint8_t kUnseenIndex = 2;
constexpr uint8_t kFreeIndex = 3;
constexpr int kFirstRampIndex = 4;
constexpr int kNumRampColors = 256 - kFirstRampIndex;

uint8_t RampIndex(double value, const Scale& scale) {
  const double share = (value - scale.min) / (scale.max - scale.min);
  return static_cast<uint8_t>(kFirstRampIndex +
                              std::lround(std::clamp(share, 0.0, 1.0) * (kNumRampColors - 1)));
}

// Calls draw(row, col, place, cell) for each pixel whose centre is in a window; row and column are
// those in the box.
template <typename Draw>
void ForEachCenter(const PixelPlaces& places, const CellFinder& finder, Draw draw) {
  const cv::Rect& box = places.box();
  for (int row = 0; row < box.height; ++row) {
    const auto line = places.Row({box.x + 0.5, box.y + row + 0.5}, 1.0, box.width);
    for (int col = 0; col < box.width; ++col) {
      const WindowCell cell = finder.At(line[col]);
      if (cell.window) draw(row, col, line[col], cell);
    }
  }
}

// Rasters of the layer, one per window; an empty one draws nothing.
std::vector<LayerRaster> RastersOf(MapLayer layer, const std::vector<MapWindow>& windows) {
  std::vector<LayerRaster> rasters;
  rasters.reserve(windows.size());
  for (const MapWindow& window : windows) rasters.push_back(RasterOf(window, layer));
  return rasters;
}

template <typename Draw>
void ForEachValue(MapLayer layer,
                  const PixelPlaces& places,
                  const std::vector<MapWindow>& windows,
                  Draw draw) {
  const std::vector<LayerRaster> rasters = RastersOf(layer, windows);
  ForEachCenter(places,
                CellFinder(windows),
                [&](int row, int col, const Eigen::Vector2d& place, const WindowCell& cell) {
                  const LayerRaster& raster = rasters[cell.index];
                  if (raster.IsEmpty()) return;
                  const float value = raster.At(cell.row, cell.col);
                  if (std::isfinite(value)) draw(row, col, place, cell, value);
                });
}

cv::Mat1b SafetyIndices(MapLayer layer,
                        const PixelPlaces& places,
                        const std::vector<MapWindow>& windows,
                        const Scale& scale) {
  const bool has_values = layer != MapLayer::kHazard;
  const Safety safety = SafetyOf(places, windows, layer);
  cv::Mat1b indices(safety.state.size(), kTransparentIndex);
  for (int row = 0; row < indices.rows; ++row) {
    for (int col = 0; col < indices.cols; ++col) {
      const uint8_t state = safety.state(row, col);
      if (state == kFree) {
        indices(row, col) = has_values ? RampIndex(safety.value(row, col), scale) : kFreeIndex;
      } else if (state != Safety::kOutside) {
        indices(row, col) = state == kHazard ? kHazardIndex : kUnseenIndex;
      }
    }
  }
  return indices;
}

cv::Mat1f SafetyValues(MapLayer layer,
                       const PixelPlaces& places,
                       const std::vector<MapWindow>& windows) {
  const bool has_values = layer != MapLayer::kHazard;
  const Safety safety = SafetyOf(places, windows, layer);
  const float of_hazard = layer == MapLayer::kRisk ? 1.0f : 0.0f;
  cv::Mat1f values(safety.state.size(), kNoData);
  for (int row = 0; row < values.rows; ++row) {
    for (int col = 0; col < values.cols; ++col) {
      const uint8_t state = safety.state(row, col);
      if (state == Safety::kOutside || (has_values && state == kUnseen)) continue;
      values(row, col) = !has_values      ? static_cast<float>(state)
                         : state == kFree ? safety.value(row, col)
                                          : of_hazard;
    }
  }
  return values;
}

}  // namespace

Palette PaletteOf(const std::string& layer) {
  Palette palette;
  palette[kTransparentIndex] = {0, 0, 0, 0};
  palette[kHazardIndex] = Bgra(kHazardColor);
  palette[kUnseenIndex] = Bgra(kUnseenColor);
  palette[kFreeIndex] = Bgra(kFreeColor);
  for (int i = 0; i < kNumRampColors; ++i) {
    palette[kFirstRampIndex + i] = Bgra(RampColor(layer, i / (kNumRampColors - 1.0)));
  }
  return palette;
}

cv::Mat1b IndicesOf(MapLayer layer,
                    const PixelPlaces& places,
                    const std::vector<MapWindow>& windows,
                    const Scale& scale) {
  if (IsSafetyLayer(layer)) {
    return SafetyIndices(layer, places, windows, scale);
  }
  cv::Mat1b indices(places.box().size(), kTransparentIndex);
  ForEachValue(layer,
               places,
               windows,
               [&](int row, int col, const Eigen::Vector2d&, const WindowCell&, float value) {
                 indices(row, col) = RampIndex(value, scale);
               });
  return indices;
}

cv::Mat4b ElevationPicture(const PixelPlaces& places,
                           const std::vector<MapWindow>& windows,
                           const Scale& scale,
                           const LocalFrame& local_frame) {
  const Palette palette = PaletteOf("elevation");
  cv::Mat4b picture(places.box().size(), cv::Vec4b(0, 0, 0, 0));
  const auto draw =
      [&](int row, int col, const Eigen::Vector2d& place, const WindowCell& cell, float height) {
        const ElevationMap& map = cell.window->site_map.map;
        const cv::Vec4b& bgra =
            palette[RampIndex(height + AltitudeOfPlane(place, local_frame), scale)];
        picture(row, col) =
            Bgra(Shade({bgra[2], bgra[1], bgra[0]},
                       Hillshade(map.elevation, cell.row, cell.col, map.grid.cell_size_m)));
      };
  ForEachValue(MapLayer::kElevation, places, windows, draw);
  return picture;
}

cv::Mat1f ValuesOf(MapLayer layer,
                   const PixelPlaces& places,
                   const std::vector<MapWindow>& windows,
                   const LocalFrame& local_frame) {
  if (IsSafetyLayer(layer)) {
    return SafetyValues(layer, places, windows);
  }
  cv::Mat1f values(places.box().size(), kNoData);
  const auto draw =
      [&](int row, int col, const Eigen::Vector2d& place, const WindowCell& cell, float value) {
        if (layer == MapLayer::kElevation) {
          value += static_cast<float>(AltitudeOfPlane(place, local_frame));
        } else if (layer == MapLayer::kGrass) {
          value = value >= cell.window->site_map.layers.min_grass_posterior ? 1.0f : 0.0f;
        }
        values(row, col) = value;
      };
  ForEachValue(layer, places, windows, draw);
  return values;
}

}  // namespace freelsd
