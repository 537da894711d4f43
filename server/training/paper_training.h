// Input: labelled photographs. Output: the classifiers of the paper, trained and validated as
// published. Paper: Sec. III-D, IV-A.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "server/training/training_data.h"

namespace freelsd {

// The regions of all photographs with their 18 features: no tiles and no varied copies.
std::vector<TrainingSample> PaperSamples(const Photographs& photographs);

// How the forests of the paper are chosen.
TrainingOptions PaperTraining(FeatureSet feature_set, int seed);

// Errors and areas under the ROC curve, by ten random folds and with each place left out: forests
// on rgb, hsv, rgbhsv and paper18, and the perceptron on paper18. `samples` have paper18 features.
nlohmann::ordered_json PaperScores(const std::vector<TrainingSample>& samples, int seed);

}  // namespace freelsd
