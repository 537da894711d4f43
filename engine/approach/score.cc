#include "engine/approach/score.h"

#include <algorithm>
#include <cmath>

namespace freelsd {
namespace {

// A term is full when the quantity is this many times what the aircraft needs.
constexpr double kPlentyOfDistance = 3.0;
constexpr double kPlentyOfClearance = 3.0;
constexpr double kPlentyOfArea = 5.0;
// Observations after which more say little new.
constexpr double kPlentyOfObservations = 10.0;
// Share of its score that a site keeps by verdict, so that verdicts never interleave.
constexpr double kUnverifiedShare = 0.8;
constexpr double kRejectedShare = 0.2;

// 0..1; unknown counts as the worst.
double Term(double value) { return std::isfinite(value) ? std::clamp(value, 0.0, 1.0) : 0.0; }

}  // namespace

std::vector<ScoreTerm> ScoreTerms(const Plan& plan,
                                  const PlanRequest& request,
                                  const Aircraft& aircraft,
                                  const ApproachOptions& options) {
  const double clearance = plan.approach ? plan.approach->min_clearance : 0.0;
  const double seen = plan.approach ? 1.0 - plan.approach->unseen_ratio : 0.0;
  const double touchdown_disc = std::max(aircraft.touchdown_uncertainty_m, 1.0);
  const double margin = std::max(aircraft.safety_margin_m, 1.0);
  const double evidence = request.grade * (request.num_observations / kPlentyOfObservations);
  const double values[] = {
      plan.hazard_distance / (kPlentyOfDistance * touchdown_disc),
      clearance / (kPlentyOfClearance * margin),
      request.area_m2 / (kPlentyOfArea * aircraft.min_area_m2),
      1.0 - DegFromRad(plan.slope) / aircraft.max_slope_deg,
      1.0 - plan.roughness / aircraft.max_roughness_m,
      0.5 * (Term(evidence) + seen),
  };
  const char* const names[] = {
      "hazard_distance", "clearance", "area", "slope", "roughness", "evidence"};
  std::vector<ScoreTerm> terms;
  for (size_t i = 0; i < std::size(values); ++i) {
    terms.push_back({names[i], Term(values[i]), options.score_weights[i]});
  }
  return terms;
}

double Score(const std::vector<ScoreTerm>& terms, Verdict verdict) {
  double sum = 0.0, sum_of_weights = 0.0;
  for (const ScoreTerm& term : terms) {
    sum += term.weight * term.value;
    sum_of_weights += term.weight;
  }
  const double mean = sum_of_weights > 0.0 ? sum / sum_of_weights : 0.0;
  switch (verdict) {
    case Verdict::kLandable:
      return mean;
    case Verdict::kUnverified:
      return kUnverifiedShare * mean;
    case Verdict::kRejected:
      break;
  }
  return kRejectedShare * mean;
}

}  // namespace freelsd
