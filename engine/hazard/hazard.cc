#include "engine/hazard/hazard.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "engine/check/check.h"
#include "engine/hazard/distance_transform.h"

namespace freelsd {
namespace {

void CheckLimits(const HazardLimits& limits) {
  const FieldCheck check("hazard");
  check.Inside("max_slope_deg", limits.max_slope_deg, 0.0, 90.0);
  check.Inside("max_roughness_m", limits.max_roughness_m, 0.0, 1000.0);
}

Hazard ClassOf(const CellRules& rules) {
  if (!rules.front().passed) return kUnseen;
  const bool is_free =
      std::all_of(rules.begin(), rules.end(), [](const CellRule& rule) { return rule.passed; });
  return is_free ? kFree : kHazard;
}

cv::Mat1b ClassesOf(const ElevationMap& map,
                    const HazardLayers& layers,
                    const HazardLimits& limits,
                    const HazardOptions& options) {
  cv::Mat1b classes(map.elevation.size(), kUnseen);
  for (int row = 0; row < classes.rows; ++row) {
    for (int col = 0; col < classes.cols; ++col) {
      classes(row, col) = ClassOf(CellRulesAt(map, layers, {col, row}, limits, options));
    }
  }
  return classes;
}

}  // namespace

// Comparisons are written so that NaN fails them.
CellRules CellRulesAt(const ElevationMap& map,
                      const HazardLayers& layers,
                      const cv::Point& cell,
                      const HazardLimits& limits,
                      const HazardOptions& options) {
  const double deviation = map.standard_deviation(cell), grass = layers.grass(cell);
  const double slope = layers.slope(cell), roughness = layers.roughness(cell);
  const double excess = map.upper(cell) - map.elevation(cell);
  const double max_deviation = options.surface.max_standard_deviation_m;
  const double min_grass = options.cover.min_grass_posterior;
  const double max_slope = RadFromDeg(limits.max_slope_deg - map.tilt_sd_deg);
  const double max_excess = limits.max_roughness_m + options.cover.upper_margin_m;
  const bool is_seen = std::isfinite(map.elevation(cell)) && deviation <= max_deviation &&
                       std::isfinite(slope) && std::isfinite(roughness);
  return {CellRule{CellCondition::kSeen, is_seen, deviation, max_deviation},
          {CellCondition::kGrass, grass >= min_grass, grass, min_grass},
          {CellCondition::kNotSteep, slope <= max_slope, slope, max_slope},
          {CellCondition::kNotRough,
           roughness <= limits.max_roughness_m,
           roughness,
           limits.max_roughness_m},
          {CellCondition::kNoObject, excess <= max_excess, excess, max_excess}};
}

void HazardOptions::Check() const {
  surface.Check();
  cover.Check();
}

AssessedMap AssessHazards(const ElevationMap& map,
                          const GroundSurface& surface,
                          const GroundCover& cover,
                          const HazardLimits& limits,
                          const HazardOptions& options) {
  HazardLayers layers;
  layers.grid = map.grid;
  layers.slope = surface.slope;
  layers.roughness = surface.roughness;
  layers.grass = cover.grass;
  layers.kind = cover.kind;
  AssessedMap finished = Rounded(WithCover(map, cover.open), layers);
  finished.layers = WithLimits(finished.map, finished.layers, limits, options);
  return finished;
}

HazardLayers WithLimits(const ElevationMap& map,
                        const HazardLayers& layers,
                        const HazardLimits& limits,
                        const HazardOptions& options) {
  options.Check();
  CheckLimits(limits);
  if (!(layers.grid == map.grid)) {
    throw std::invalid_argument("hazard.grid: layers and map are not of the same grid");
  }
  HazardLayers renewed = layers;
  renewed.hazard = ClassesOf(map, layers, limits, options);
  renewed.distance = DistanceToHazard(renewed.hazard, map.grid.cell_size_m);
  renewed.max_object_height_m = limits.max_roughness_m + options.cover.upper_margin_m;
  renewed.min_grass_posterior = options.cover.min_grass_posterior;
  renewed.min_clear_class_posterior = options.cover.clear_class.min_clear_class_posterior;
  return renewed;
}

}  // namespace freelsd
