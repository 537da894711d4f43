#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "api/export/legend.h"
#include "api/export/map/map_layer.h"

namespace freelsd {
namespace {

// Twice the usual limits, so that the limits are at the middle of the ramp.
constexpr Scale kSlopeScale{0.0, 16.0};
constexpr Scale kRoughnessScale{0.0, 1.0};
constexpr Scale kHeightSdScale{0.0, 2.0};
constexpr Scale kHazardScale{0.0, 2.0};
constexpr Scale kGrassScale{0.0, 1.0};
constexpr Scale kRiskScale{0.0, 0.2};
// One step for each kind.
constexpr Scale kKindScale{-0.5, kNumGroundKinds - 0.5};
// Share of the heights beyond each end of the ramp.
constexpr double kTailShare = 0.01;

std::vector<float> SeenValues(const LayerRaster& raster, const Grid& grid) {
  std::vector<float> values;
  if (raster.IsEmpty()) return values;
  for (int row = 0; row < grid.num_rows; ++row) {
    for (int col = 0; col < grid.num_cols; ++col) {
      const float value = raster.At(row, col);
      if (std::isfinite(value)) values.push_back(value);
    }
  }
  return values;
}

Scale ScaleOfHeights(std::vector<float> heights, double altitude_m) {
  const auto tail = static_cast<std::ptrdiff_t>(kTailShare * static_cast<double>(heights.size()));
  std::nth_element(heights.begin(), heights.begin() + tail, heights.end());
  const double low = heights[tail];
  std::nth_element(heights.begin(), heights.end() - 1 - tail, heights.end());
  const double high = *(heights.end() - 1 - tail);
  return {altitude_m + low, altitude_m + std::max(high, low + 1.0)};
}

std::optional<Scale> FixedScale(MapLayer layer) {
  if (layer == MapLayer::kSlope) return kSlopeScale;
  if (layer == MapLayer::kRoughness) return kRoughnessScale;
  if (layer == MapLayer::kHeightSd) return kHeightSdScale;
  if (layer == MapLayer::kHazard) return kHazardScale;
  if (layer == MapLayer::kGrass) return kGrassScale;
  if (layer == MapLayer::kRisk) return kRiskScale;
  if (layer == MapLayer::kKind) return kKindScale;
  return std::nullopt;
}

}  // namespace

void CheckScale(const Scale& scale) {
  if (std::isfinite(scale.min) && std::isfinite(scale.max) && scale.min < scale.max) return;
  throw std::invalid_argument("scale = " + std::to_string(scale.min) + " to " +
                              std::to_string(scale.max) + ": must be finite and ascending");
}

std::optional<Scale> MapScale(const std::string& layer,
                              const MapWindow& window,
                              const LocalFrame& local_frame) {
  const MapLayer map_layer = ValueLayerOf(layer);
  CheckWindow(window);
  const Grid& grid = window.site_map.map.grid;
  const std::optional<Scale> fixed = FixedScale(map_layer);
  if (map_layer == MapLayer::kHazard || map_layer == MapLayer::kRisk) return fixed;
  std::vector<float> values = SeenValues(RasterOf(window, map_layer), grid);
  if (values.empty()) return std::nullopt;
  if (fixed) return fixed;
  if (map_layer != MapLayer::kElevation) {
    return Scale{0.0, std::max(1.0f, *std::max_element(values.begin(), values.end()))};
  }
  const std::vector<Eigen::Vector2d> corners = OuterCorners(grid);
  return ScaleOfHeights(std::move(values),
                        AltitudeOfPlane(0.5 * (corners[0] + corners[2]), local_frame));
}

Scale RiskScale() { return kRiskScale; }

Scale MergedScale(const Scale& a, const Scale& b) {
  return {std::min(a.min, b.min), std::max(a.max, b.max)};
}

std::string MapLegendPng(const std::string& layer, const Scale& scale) {
  ValueLayerOf(layer);
  CheckScale(scale);
  return LegendPng(layer, scale);
}

}  // namespace freelsd
