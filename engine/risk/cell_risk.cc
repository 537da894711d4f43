#include <algorithm>
#include <array>
#include <cmath>

#include "engine/risk/risk.h"

namespace freelsd {
namespace {

struct ShapeRisk {
  double ratio;
  double probability;
};
// Linear between the points. Measured by `freelsd-eval`, section "ground called grass, by its
// shape", on tuning worlds.
constexpr std::array<ShapeRisk, 8> kShapeRisks{{{0.1, 0.0005},
                                                {0.25, 0.0018},
                                                {0.35, 0.0037},
                                                {0.45, 0.0063},
                                                {0.575, 0.011},
                                                {0.725, 0.018},
                                                {0.9, 0.066},
                                                {1.25, 0.8}}};

}  // namespace

double RiskOfShape(double shape_ratio) {
  if (std::isnan(shape_ratio)) return 1.0;
  const auto above = std::find_if(kShapeRisks.begin(), kShapeRisks.end(), [&](const ShapeRisk& at) {
    return at.ratio > shape_ratio;
  });
  if (above == kShapeRisks.end()) return kShapeRisks.back().probability;
  if (above == kShapeRisks.begin()) return kShapeRisks.front().probability;
  const ShapeRisk& below = *(above - 1);
  const double share = (shape_ratio - below.ratio) / (above->ratio - below.ratio);
  return below.probability + share * (above->probability - below.probability);
}

double ShapeRatio(const ElevationMap& map,
                  const HazardLayers& layers,
                  const Aircraft& aircraft,
                  const cv::Point& cell) {
  const double slope = layers.slope(cell) / RadFromDeg(aircraft.max_slope_deg);
  const double roughness = layers.roughness(cell) / aircraft.max_roughness_m;
  const double object = (map.upper(cell) - map.elevation(cell)) / layers.max_object_height_m;
  return std::max({slope, roughness, object});
}

std::optional<CellRisk> RiskOfCell(const ElevationMap& map,
                                   const HazardLayers& layers,
                                   const Aircraft& aircraft,
                                   const cv::Point& cell) {
  if (layers.hazard(cell) == kUnseen) return std::nullopt;
  const double grass = layers.grass(cell), upper = map.upper(cell);
  return CellRisk{.kind = std::isnan(grass) ? 1.0 : 1.0 - grass,
                  .shape = RiskOfShape(ShapeRatio(map, layers, aircraft, cell)),
                  .top = std::isnan(upper) ? map.elevation(cell) : upper,
                  .top_sd = map.standard_deviation(cell)};
}

}  // namespace freelsd
