// A trained forest.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <opencv2/ml.hpp>

#include "engine/classification/classification.h"

namespace freelsd {

struct Classifier::Model {
  FeatureSet feature_set = FeatureSet::kPaper18;
  std::string provenance;
  cv::Ptr<cv::ml::RTrees> forest;
};

// Share of the trees that vote for grass.
double GrassVotes(const cv::ml::RTrees& forest, const std::vector<float>& features);

}  // namespace freelsd
