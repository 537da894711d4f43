#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "engine/approach/approach.h"
#include "engine/check/check.h"

namespace freelsd {
namespace {

// Distance to hazard, clearance, area, slope, roughness, evidence.
constexpr size_t kNumScoreTerms = 6;
// Each start height needs a search of its own.
constexpr size_t kMaxNumStartHeights = 10;
constexpr double kMinStartHeightRatio = 0.1;
constexpr double kMaxStartHeightRatio = 20.0;

void CheckWeights(const std::vector<double>& weights, const FieldCheck& check) {
  if (weights.size() != kNumScoreTerms) {
    throw std::invalid_argument("approach.score_weights = " + std::to_string(weights.size()) +
                                " numbers: must be " + std::to_string(kNumScoreTerms));
  }
  for (const double weight : weights) check.Inside("score_weights", weight, 0.0, 1e6);
  if (std::accumulate(weights.begin(), weights.end(), 0.0) <= 0.0) {
    throw std::invalid_argument("approach.score_weights = all 0: must have a positive sum");
  }
}

void CheckStartHeights(const std::vector<double>& ratios, const FieldCheck& check) {
  if (ratios.empty() || ratios.size() > kMaxNumStartHeights) {
    throw std::invalid_argument("approach.start_height_ratios = " + std::to_string(ratios.size()) +
                                " numbers: must be 1 to " + std::to_string(kMaxNumStartHeights));
  }
  double least = kMinStartHeightRatio;
  for (const double ratio : ratios) {
    check.Inside("start_height_ratios", ratio, least, kMaxStartHeightRatio);
    least = ratio;
  }
}

}  // namespace

void ApproachOptions::Check() const {
  const FieldCheck check("approach");
  check.Inside("min_map_position_sd_m", min_map_position_sd_m, 0.0, 100.0);
  check.Inside("unclear_height_allowance_m", unclear_height_allowance_m, 0.0, 100.0);
  check.Inside("max_height_sd_m", max_height_sd_m, 0.01, 100.0);
  check.Inside("tilt_sigma", tilt_sigma, 0.0, 10.0);
  check.Inside("bare_ground_radius_m", bare_ground_radius_m, 0.0, 20.0);
  check.Inside("max_bare_roughness_m", max_bare_roughness_m, 0.0, 10.0);
  check.Inside("max_crosswind_ratio", max_crosswind_ratio, 0.0, 1.0);
  check.Inside("unknown_wind_mps", unknown_wind_mps, 0.0, 100.0);
  check.Inside("wind_sigma", wind_sigma, 0.0, 10.0);
  check.Inside("disc_margin_sigma", disc_margin_sigma, 1.0, 10.0);
  check.Inside("path_margin_sigma", path_margin_sigma, 0.0, 10.0);
  check.Inside("max_num_candidates", max_num_candidates, 1.0, 1e6);
  check.Inside("max_num_reserve_candidates", max_num_reserve_candidates, 0.0, 1e6);
  check.Inside("candidate_spacing_m", candidate_spacing_m, 0.0, 1000.0);
  check.Inside("heading_step_deg", heading_step_deg, 1.0, 180.0);
  check.Inside("calm_wind_mps", calm_wind_mps, 0.0, 10.0);
  check.Inside("path_step_m", path_step_m, 0.05, 5.0);
  check.Inside("max_num_rejections", max_num_rejections, 0.0, 1e6);
  CheckStartHeights(start_height_ratios, check);
  CheckWeights(score_weights, check);
}

}  // namespace freelsd
