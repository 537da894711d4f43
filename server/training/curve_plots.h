// Plots ROC and precision-recall curves of a classifier's answers.
#pragma once

#include <string>
#include <vector>

#include "server/training/training_scores.h"

namespace freelsd {

// An SVG of both plots, with one curve for each place and one for all places. Leaves out unlabelled
// regions and dormant grass, which count neither as grass nor as other ground.
std::string CurvePlots(const std::vector<Answer>& answers);

}  // namespace freelsd
