// Draws ROC and precision-recall curves of a classifier's answers.
#pragma once

#include <string>
#include <vector>

#include "server/training/training_scores.h"

namespace freelsd {

// An SVG of both curves, with one line for each place and one for all places. Leaves out regions of
// classes that are neither grass nor not grass.
std::string CurvePlots(const std::vector<Answer>& answers);

}  // namespace freelsd
