#include "engine/hazard/hazard.h"

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

// Comparisons are written so that NaN fails them.
Hazard ClassOf(const ElevationMap& map,
               const HazardLayers& layers,
               const cv::Point& cell,
               const HazardLimits& limits,
               const HazardOptions& options) {
  const bool is_seen = std::isfinite(map.elevation(cell)) &&
                       map.standard_deviation(cell) <= options.surface.max_standard_deviation_m &&
                       std::isfinite(layers.slope(cell)) && std::isfinite(layers.roughness(cell));
  if (!is_seen) return kUnseen;
  const double max_excess = limits.max_roughness_m + options.cover.upper_margin_m;
  const bool is_free = layers.grass(cell) >= options.cover.min_grass_posterior &&
                       layers.slope(cell) <= RadFromDeg(limits.max_slope_deg - map.tilt_sd_deg) &&
                       layers.roughness(cell) <= limits.max_roughness_m &&
                       map.upper(cell) - map.elevation(cell) <= max_excess;
  return is_free ? kFree : kHazard;
}

cv::Mat1b ClassesOf(const ElevationMap& map,
                    const HazardLayers& layers,
                    const HazardLimits& limits,
                    const HazardOptions& options) {
  cv::Mat1b classes(map.elevation.size(), kUnseen);
  for (int row = 0; row < classes.rows; ++row) {
    for (int col = 0; col < classes.cols; ++col) {
      classes(row, col) = ClassOf(map, layers, {col, row}, limits, options);
    }
  }
  return classes;
}

}  // namespace

void HazardOptions::Check() const {
  surface.Check();
  cover.Check();
}

HazardLayers AssessHazards(const ElevationMap& map,
                           const GroundSurface& surface,
                           const GroundCover& cover,
                           const HazardLimits& limits,
                           const HazardOptions& options) {
  HazardLayers layers;
  layers.grid = map.grid;
  layers.slope = surface.slope;
  layers.roughness = surface.roughness;
  layers.grass = cover.grass;
  return WithLimits(WithCover(map, cover.open), layers, limits, options);
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
  renewed.min_grass_posterior = options.cover.min_grass_posterior;
  renewed.min_clear_class_posterior = options.cover.clear_class.min_clear_class_posterior;
  return renewed;
}

}  // namespace freelsd
