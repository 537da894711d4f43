// The terms that a site's score is made of.
#pragma once

#include <vector>

#include "engine/approach/approach.h"

namespace freelsd {

// Each term 0..1, weights as in the options.
std::vector<ScoreTerm> ScoreTerms(const Plan& plan,
                                  const PlanRequest& request,
                                  const Aircraft& aircraft,
                                  const ApproachOptions& options);

// Weighted mean of the terms; a rejected site never scores above one that may be landed on.
double Score(const std::vector<ScoreTerm>& terms, Verdict verdict);

}  // namespace freelsd
