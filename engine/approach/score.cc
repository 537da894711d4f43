#include "engine/approach/score.h"

#include <algorithm>
#include <cmath>

namespace freelsd {
namespace {

// Terms saturate where more would not make the landing safer.
constexpr double kAmpleHazardDistances = 3.0;  // times the one needed
constexpr double kAmpleClearances = 2.0;       // times the one wanted: what flat ground gives
constexpr double kAmpleAreas = 4.0;            // times the least area
constexpr double kAmpleObservations = 2.0;     // times n_obs,min
constexpr double kWeightOfUnseenCircle = 0.5;  // of the evidence
constexpr double kLargestRejectedScore = 0.2;

// 0 for NaN too: unknown is never good.
double Share(double value, double ample) {
  return value > 0.0 && ample > 0.0 ? std::min(value / ample, 1.0) : 0.0;
}

}  // namespace

std::vector<ScoreTerm> ScoreTerms(const ScoreInput& input,
                                  const PlanRequest& request,
                                  const Aircraft& aircraft,
                                  const ApproachOptions& options) {
  const double evidence =
      request.grade * Share(request.num_observations,
                            kAmpleObservations * std::max(request.min_num_observations, 1));
  const std::vector<double>& weights = options.score_weights;
  return {
      {"hazard_distance",
       Share(input.hazard_distance, kAmpleHazardDistances * input.required_hazard_distance),
       weights[0]},
      {"clearance", Share(input.clearance_ratio, kAmpleClearances), weights[1]},
      {"area", Share(request.area_m2, kAmpleAreas * aircraft.min_area_m2), weights[2]},
      {"slope", Share(1.0 - input.slope / RadFromDeg(aircraft.max_slope_deg), 1.0), weights[3]},
      {"roughness", Share(1.0 - input.roughness / aircraft.max_roughness_m, 1.0), weights[4]},
      {"evidence",
       Share(evidence * (1.0 - kWeightOfUnseenCircle * input.unseen_ratio), 1.0),
       weights[5]},
  };
}

double Score(const std::vector<ScoreTerm>& terms, Verdict verdict) {
  double sum = 0.0, sum_of_weights = 0.0;
  for (const ScoreTerm& term : terms) {
    sum += term.weight * term.value;
    sum_of_weights += term.weight;
  }
  const double mean = sum_of_weights > 0.0 ? sum / sum_of_weights : 0.0;
  return verdict == Verdict::kRejected ? kLargestRejectedScore * mean : mean;
}

}  // namespace freelsd
