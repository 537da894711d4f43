// ROC and precision-recall curves of a classifier's answers.
#pragma once

#include <string>
#include <vector>

#include "server/training_scores.h"

namespace freelsd {

// An SVG of both, one line per place and one of all. Regions that tell neither grass nor not are
// left out.
std::string CurvePlots(const std::vector<Answer>& answers);

}  // namespace freelsd
