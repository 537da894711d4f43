// Private to approach/: the score of a site and its terms.
#pragma once

#include <vector>

#include "engine/approach/approach.h"

namespace freelsd {

struct ScoreInput {
  double hazard_distance = 0.0;
  double required_hazard_distance = 1.0;
  // Least ratio of clearance to the clearance needed; NaN or negative counts as 0.
  double clearance_ratio = 0.0;
  double slope = 0.0;
  double roughness = 0.0;
  double unseen_ratio = 0.0;
};

std::vector<ScoreTerm> ScoreTerms(const ScoreInput& input,
                                  const PlanRequest& request,
                                  const Aircraft& aircraft,
                                  const ApproachOptions& options);

// Weighted mean of the terms, 0..1; multiplied by 0.2 if the site is rejected.
double Score(const std::vector<ScoreTerm>& terms, Verdict verdict);

}  // namespace freelsd
