#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/hazard/hazard.h"

namespace freelsd {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

enum class Direction { kUp, kDown };

float RoundedTo(float value, float step, Direction direction) {
  if (std::isnan(value)) return kNaN;
  constexpr float kMost = MapSteps::kMaxNumSteps;
  if (direction == Direction::kDown) return std::min(std::floor(value / step), kMost) * step;
  const float num_steps = std::ceil(value / step);
  return num_steps <= kMost ? num_steps * step : kNaN;
}

cv::Mat1f RoundedTo(const cv::Mat1f& raster, float step, Direction direction) {
  cv::Mat1f rounded(raster.size());
  std::transform(raster.begin(), raster.end(), rounded.begin(), [&](float value) {
    return RoundedTo(value, step, direction);
  });
  return rounded;
}

float NearestHeight(float height) {
  return std::round(height / MapSteps::kHeightM) * MapSteps::kHeightM;
}

// Never below the given height. An object that is too high for the steps stays an object.
float UpperHeight(float upper, float rounded_elevation) {
  if (std::isnan(upper)) return kNaN;
  if (std::isnan(rounded_elevation)) {
    return std::ceil(upper / MapSteps::kHeightM) * MapSteps::kHeightM;
  }
  const float num_steps = std::ceil((upper - rounded_elevation) / MapSteps::kHeightM);
  const float most = static_cast<float>(MapSteps::kMaxNumSteps);
  return rounded_elevation + std::clamp(num_steps, 0.0f, most) * MapSteps::kHeightM;
}

cv::Mat1f CopyOf(const cv::Mat1f& raster, const cv::Rect& cells) { return raster(cells).clone(); }

}  // namespace

AssessedMap Rounded(const ElevationMap& map, const HazardLayers& layers) {
  AssessedMap rounded{map, layers};
  rounded.map.elevation = cv::Mat1f(map.elevation.size());
  rounded.map.upper = cv::Mat1f(map.upper.size());
  for (int row = 0; row < map.elevation.rows; ++row) {
    for (int col = 0; col < map.elevation.cols; ++col) {
      const float elevation = NearestHeight(map.elevation(row, col));
      rounded.map.elevation(row, col) = elevation;
      rounded.map.upper(row, col) = UpperHeight(map.upper(row, col), elevation);
    }
  }
  rounded.map.standard_deviation =
      RoundedTo(map.standard_deviation, MapSteps::kHeightM, Direction::kUp);
  rounded.map.num_points = RoundedTo(map.num_points, 1.0f, Direction::kDown);
  rounded.layers.slope = RoundedTo(layers.slope, MapSteps::kSlope, Direction::kUp);
  rounded.layers.roughness = RoundedTo(layers.roughness, MapSteps::kRoughnessM, Direction::kUp);
  rounded.layers.grass = RoundedTo(layers.grass, MapSteps::kGrass, Direction::kDown);
  return rounded;
}

AssessedMap WindowOf(const ElevationMap& map, const HazardLayers& layers, const cv::Rect& cells) {
  const Grid grid = map.grid.Part(cells);
  return {{.grid = grid,
           .elevation = CopyOf(map.elevation, cells),
           .upper = CopyOf(map.upper, cells),
           .standard_deviation = CopyOf(map.standard_deviation, cells),
           .num_points = CopyOf(map.num_points, cells),
           .position_sd_m = map.position_sd_m,
           .tilt_sd_deg = map.tilt_sd_deg,
           .is_compared = map.is_compared},
          {.grid = grid,
           .slope = CopyOf(layers.slope, cells),
           .roughness = CopyOf(layers.roughness, cells),
           .grass = CopyOf(layers.grass, cells),
           .kind = layers.kind.empty() ? cv::Mat1b() : layers.kind(cells).clone(),
           .hazard = layers.hazard(cells).clone(),
           .distance = CopyOf(layers.distance, cells),
           .min_clear_class_posterior = layers.min_clear_class_posterior,
           .min_grass_posterior = layers.min_grass_posterior,
           .max_object_height_m = layers.max_object_height_m}};
}

}  // namespace freelsd
