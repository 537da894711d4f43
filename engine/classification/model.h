// A trained forest, its calibration, and the ranges of the features in the training grass.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <opencv2/ml.hpp>

#include "engine/classification/classification.h"

namespace freelsd {

struct Classifier::Model {
  FeatureSet feature_set = FeatureSet::kRobust;
  std::string provenance;
  cv::Ptr<cv::ml::RTrees> forest;
  // Calibrated probability = 1 / (1 + exp(-(slope * votes + offset))), votes in 0..1 (Platt 1999).
  double calibration_slope = 1.0;
  double calibration_offset = 0.0;
  // Range of each feature over the grass of the training data.
  std::vector<float> grass_min;
  std::vector<float> grass_max;
};

// Share of the trees that vote for grass.
double GrassVotes(const cv::ml::RTrees& forest, const std::vector<float>& features);

}  // namespace freelsd
