// A trained forest. Unless it is in the published form: its calibration, and the ranges of the
// features in the training grass.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/ml.hpp>

#include "engine/classification/classification.h"

namespace freelsd {

// Calibrated probability = 1 / (1 + exp(-(slope * votes + offset))), votes in 0..1 (Platt 1999).
struct Calibration {
  double slope = 1.0;
  double offset = 0.0;
};

struct Classifier::Model {
  FeatureSet feature_set = FeatureSet::kRobust;
  std::string provenance;
  cv::Ptr<cv::ml::RTrees> forest;
  // Empty: the share of votes is the probability, as in the paper.
  std::optional<Calibration> calibration;
  // Range of each feature over the grass of the training data. Empty: no feature is out of range,
  // as in the paper.
  std::vector<float> grass_min;
  std::vector<float> grass_max;
};

// Share of the trees that vote for grass.
double GrassVotes(const cv::ml::RTrees& forest, const std::vector<float>& features);

}  // namespace freelsd
