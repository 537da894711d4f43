// Cross-validation of whatever learns from samples.
#pragma once

#include <functional>
#include <vector>

#include "engine/classification/classification.h"

namespace freelsd {

using SamplePointers = std::vector<const TrainingSample*>;
// Grass or not, from a feature row: at least 0.5 is grass.
using Predictor = std::function<double(const std::vector<float>& features)>;
using Learner = std::function<Predictor(const SamplePointers& samples)>;

struct Prediction {
  double votes = 0.0;
  bool is_grass = false;
};

// Fold of each sample, in the order of the samples.
std::vector<int> RandomFolds(size_t num_samples, int num_folds, int seed);
std::vector<int> FoldsByPlace(const std::vector<TrainingSample>& samples);

// A prediction for every sample, by a learner that saw the other folds.
std::vector<Prediction> CrossValidate(const std::vector<TrainingSample>& samples,
                                      const std::vector<int>& fold_of_sample,
                                      const Learner& learner);

double ErrorRatio(const std::vector<Prediction>& predictions);
// Area under the ROC curve: share of (grass, not grass) pairs in the right order; ties count half.
// NaN without such pairs.
double AreaUnderCurve(const std::vector<Prediction>& predictions);

// Seeds OpenCV's generator of this thread, which its learners use, and restores it afterwards.
class SeededRng {
 public:
  explicit SeededRng(int seed);
  ~SeededRng();
  SeededRng(const SeededRng&) = delete;
  SeededRng& operator=(const SeededRng&) = delete;

 private:
  cv::RNG saved_;
};

}  // namespace freelsd
