// Input: labelled photographs. Output: the classifiers of the paper, trained and validated as
// published. Paper: Sec. III-D, IV-A.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "server/training/labelled_photographs.h"

namespace freelsd {

// The regions of all photographs with their 18 features.
std::vector<TrainingSample> PaperSamples(const Photographs& photographs);

// Errors and areas under the ROC curve, by ten random folds and with each place left out: forests
// on rgb, hsv, rgbhsv and paper18, and the perceptron on paper18. `samples` have paper18 features.
nlohmann::ordered_json PaperScores(const std::vector<TrainingSample>& samples, int seed);

}  // namespace freelsd
