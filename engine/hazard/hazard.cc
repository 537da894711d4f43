#include "engine/hazard/hazard.h"

#include <cmath>
#include <stdexcept>

#include "engine/check/check.h"
#include "engine/hazard/distance_transform.h"
#include "engine/hazard/fences.h"
#include "engine/hazard/grass.h"
#include "engine/hazard/look_alikes.h"
#include "engine/hazard/overreach.h"
#include "engine/hazard/raised_fields.h"
#include "engine/hazard/small_objects.h"
#include "engine/hazard/surface.h"

namespace freelsd {
namespace {

void CheckLimits(const HazardLimits& limits) {
  const FieldCheck check("hazard");
  check.Inside("max_slope_deg", limits.max_slope_deg, 0.0, 90.0);
  check.Inside("max_roughness_m", limits.max_roughness_m, 0.0, 1000.0);
}

// Every comparison is written so that NaN fails it.
Hazard ClassOf(const ElevationMap& map,
               const HazardLayers& layers,
               const cv::Point& cell,
               const HazardLimits& limits,
               const HazardOptions& options) {
  const bool is_seen = std::isfinite(map.elevation(cell)) &&
                       map.standard_deviation(cell) <= options.max_standard_deviation_m &&
                       std::isfinite(layers.slope(cell)) && std::isfinite(layers.roughness(cell));
  if (!is_seen) return kUnseen;
  const double max_excess = limits.max_roughness_m + options.upper_margin_m;
  const bool is_free = layers.grass(cell) >= options.min_grass_posterior &&
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

void Classify(const ElevationMap& map,
              const HazardLimits& limits,
              const HazardOptions& options,
              HazardLayers& layers) {
  layers.hazard = ClassesOf(map, layers, limits, options);
  layers.distance = DistanceToHazard(layers.hazard, map.grid.cell_size_m);
}

}  // namespace

void HazardOptions::Check() const {
  const FieldCheck check("hazard");
  check.Inside("min_grass_posterior", min_grass_posterior, 0.5, 1.0);
  check.Inside("min_observation_probability", min_observation_probability, 0.001, 0.499);
  check.Inside("max_observation_probability", max_observation_probability, 0.501, 0.999);
  check.Inside("max_num_independent_views", max_num_independent_views, 1.0, 1000.0);
  check.Inside("min_vote_ratio", min_vote_ratio, 0.0, 1.0);
  check.Inside("plane_support_m", plane_support_m, 0.1, 100.0);
  check.Inside("min_support_ratio", min_support_ratio, 0.4, 1.0);
  check.Inside("roughness_spacing_m", roughness_spacing_m, 0.05, 100.0);
  check.Inside("upper_margin_m", upper_margin_m, 0.0, 10.0);
  check.Inside("max_standard_deviation_m", max_standard_deviation_m, 0.01, 100.0);
  check.Inside("min_rut_contrast", min_rut_contrast, 0.0, 1.0);
  check.Inside("rut_filter_length_m", rut_filter_length_m, 3.0, 20.0);
  check.Inside("min_track_length_m", min_track_length_m, 1.0, 1000.0);
  check.Inside("max_working_width_m", max_working_width_m, 3.0, 100.0);
  check.Inside("min_working_width_m", min_working_width_m, 3.0, max_working_width_m);
  check.Inside("sprayed_margin_m", sprayed_margin_m, 0.0, 100.0);
  check.Inside("max_field_color_deviations", max_field_color_deviations, 0.0, 100.0);
  check.Inside("max_telling_sampling_m", max_telling_sampling_m, 0.01, 10.0);
  check.Inside("min_row_strength", min_row_strength, 0.0, 1e6);
  check.Inside("max_row_spacing_m", max_row_spacing_m, 0.1, 10.0);
  check.Inside("min_row_spacing_m", min_row_spacing_m, 0.1, max_row_spacing_m);
  check.Inside("min_detail_ratio", min_detail_ratio, 0.0, 1.0);
  check.Inside("max_even_slope_deg", max_even_slope_deg, 0.0, 90.0);
  check.Inside("max_even_roughness_m", max_even_roughness_m, 0.0, 1000.0);
  check.Inside("max_border_residual_m", max_border_residual_m, 0.0, 100.0);
  check.Inside("border_ramp_m", border_ramp_m, 0.0, 8.0);
  check.Inside("min_raised_step_m", min_raised_step_m, 0.0, 100.0);
  check.Inside("min_raised_border_m", min_raised_border_m, 0.0, 1e4);
  check.Inside("min_raised_border_ratio", min_raised_border_ratio, 0.0, 1.0);
  check.Inside("min_overreach_deviations", min_overreach_deviations, 0.0, 1000.0);
  check.Inside("overreach_surroundings_m", overreach_surroundings_m, 1.0, 200.0);
  check.Inside("min_object_deviations", min_object_deviations, 0.0, 1000.0);
  check.Inside("object_surroundings_m", object_surroundings_m, 1.0, 40.0);
  check.Inside("min_object_area_m2", min_object_area_m2, 0.0, 1000.0);
  check.Inside("max_surroundings_deviations", max_surroundings_deviations, 0.5, 1000.0);
  check.Inside("min_fence_deviations", min_fence_deviations, 0.0, 1000.0);
  check.Inside("fence_filter_length_m", fence_filter_length_m, 4.0, 100.0);
  check.Inside("min_post_deviations", min_post_deviations, 0.0, 1000.0);
  check.Inside("min_num_posts", min_num_posts, 0, 100);
}

HazardLayers AssessHazards(const ElevationMap& map,
                           const std::vector<GrassView>& grass_views,
                           const HazardLimits& limits,
                           const HazardOptions& options,
                           const Orthophoto& photo) {
  options.Check();
  CheckLimits(limits);
  const double cell_size_m = map.grid.cell_size_m;
  const cv::Mat1f elevation = TrustedElevation(map, options.max_standard_deviation_m);
  const int spacing =
      std::max(1, static_cast<int>(std::lround(options.roughness_spacing_m / cell_size_m)));
  HazardLayers layers;
  layers.grid = map.grid;
  layers.slope = options.slope_support == SlopeSupport::kPlane
                     ? PlaneSlope(elevation, cell_size_m, options)
                     : PaperPcaSlope(elevation, cell_size_m, options);
  layers.roughness = Ruggedness(elevation, spacing);
  layers.grass = FuseGrass(map, grass_views, options);
  if (!photo.image.empty()) {
    layers.grass.setTo(0.0f, FindLookAlikes(photo, map.grid, options));
  }
  if (!layers.grass.empty()) layers.meadow = layers.grass >= options.min_grass_posterior;
  if (!photo.image.empty()) {
    layers.objects = FindSmallObjects(photo, map.grid, options);
    if (!layers.objects.empty()) layers.grass.setTo(0.0f, layers.objects);
  }
  if (!elevation.empty()) {
    // By limits of its own: WithLimits looks for neither crops nor fences.
    const HazardLimits even{options.max_even_slope_deg, options.max_even_roughness_m};
    const cv::Mat1b is_even = ClassesOf(map, layers, even, options) == kFree;
    if (options.min_raised_step_m > 0.0) {
      layers.grass.setTo(0.0f, RaisedFields(is_even, elevation, cell_size_m, options));
    }
    if (options.min_overreach_deviations > 0.0 && !photo.image.empty()) {
      layers.grass.setTo(0.0f, OverreachingGrass(layers.grass, photo, map.grid, options));
    }
    if (options.min_fence_deviations > 0.0 && !photo.image.empty()) {
      layers.grass.setTo(0.0f, FindFences(photo, is_even, map.grid, options));
    }
  }
  Classify(map, limits, options, layers);
  return layers;
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
  Classify(map, limits, options, renewed);
  return renewed;
}

}  // namespace freelsd
