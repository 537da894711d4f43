#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>
#include <stdexcept>

#include "engine/approach/approach.h"

namespace freelsd {
namespace {

// Distance to hazard, clearance, area, slope, roughness, evidence.
constexpr size_t kNumScoreTerms = 6;
// Each is a search of its own.
constexpr size_t kMaxNumStartHeights = 10;
constexpr double kMinStartHeightRatio = 0.1;
constexpr double kMaxStartHeightRatio = 20.0;

struct Bound {
  const char* field;
  double value;
  double min;
  double max;
};

void RequireInside(const Bound& bound) {
  if (std::isfinite(bound.value) && bound.value >= bound.min && bound.value <= bound.max) return;
  std::ostringstream message;
  message << "approach." << bound.field << " = " << bound.value << ": must be in [" << bound.min
          << ", " << bound.max << "]";
  throw std::invalid_argument(message.str());
}

void CheckWeights(const std::vector<double>& weights) {
  if (weights.size() != kNumScoreTerms) {
    throw std::invalid_argument("approach.score_weights = " + std::to_string(weights.size()) +
                                " numbers: must be " + std::to_string(kNumScoreTerms));
  }
  for (const double weight : weights) RequireInside({"score_weights", weight, 0.0, 1e6});
  if (std::accumulate(weights.begin(), weights.end(), 0.0) <= 0.0) {
    throw std::invalid_argument("approach.score_weights = all 0: must have a positive sum");
  }
}

void CheckStartHeights(const std::vector<double>& ratios) {
  if (ratios.empty() || ratios.size() > kMaxNumStartHeights) {
    throw std::invalid_argument("approach.start_height_ratios = " + std::to_string(ratios.size()) +
                                " numbers: must be 1 to " + std::to_string(kMaxNumStartHeights));
  }
  double least = kMinStartHeightRatio;
  for (const double ratio : ratios) {
    RequireInside({"start_height_ratios", ratio, least, kMaxStartHeightRatio});
    least = ratio;
  }
}

}  // namespace

void ApproachOptions::Check() const {
  const Bound bounds[] = {
      {"min_map_position_sd_m", min_map_position_sd_m, 0.0, 100.0},
      {"unclear_height_allowance_m", unclear_height_allowance_m, 0.0, 100.0},
      {"min_clear_class_posterior", min_clear_class_posterior, 0.0, 1.0},
      {"max_height_sd_m", max_height_sd_m, 0.01, 100.0},
      {"tilt_sigma", tilt_sigma, 0.0, 10.0},
      {"bare_ground_radius_m", bare_ground_radius_m, 0.0, 20.0},
      {"max_bare_roughness_m", max_bare_roughness_m, 0.0, 10.0},
      {"max_crosswind_ratio", max_crosswind_ratio, 0.0, 1.0},
      {"unknown_wind_mps", unknown_wind_mps, 0.0, 100.0},
      {"disc_margin_sigma", disc_margin_sigma, 1.0, 10.0},
      {"path_margin_sigma", path_margin_sigma, 0.0, 10.0},
      {"max_num_candidates", static_cast<double>(max_num_candidates), 1.0, 1e6},
      {"max_num_reserve_candidates", static_cast<double>(max_num_reserve_candidates), 0.0, 1e6},
      {"candidate_spacing_m", candidate_spacing_m, 0.0, 1000.0},
      {"heading_step_deg", heading_step_deg, 1.0, 180.0},
      {"calm_wind_mps", calm_wind_mps, 0.0, 10.0},
      {"path_step_m", path_step_m, 0.05, 5.0},
      {"max_num_rejections", static_cast<double>(max_num_rejections), 0.0, 1e6},
  };
  for (const Bound& bound : bounds) RequireInside(bound);
  CheckStartHeights(start_height_ratios);
  CheckWeights(score_weights);
}

}  // namespace freelsd
