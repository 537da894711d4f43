#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>

#include <opencv2/ml.hpp>

#include "engine/classification/classification.h"
#include "engine/classification/validation.h"

namespace freelsd {
namespace {

// Both kinds as outputs of the network.
constexpr float kGrassOutput = 1.0f;
constexpr float kOtherOutput = -1.0f;

// Mean and deviation of each feature: the network needs inputs of about 1.
struct Scaling {
  std::vector<double> mean, deviation;
};

Scaling ScalingOf(const SamplePointers& samples) {
  const size_t num_features = samples.front()->features.size();
  const auto num_samples = static_cast<double>(samples.size());
  Scaling scaling{std::vector<double>(num_features, 0.0), std::vector<double>(num_features, 0.0)};
  for (size_t i = 0; i < num_features; ++i) {
    for (const TrainingSample* sample : samples) scaling.mean[i] += sample->features[i];
    scaling.mean[i] /= num_samples;
    for (const TrainingSample* sample : samples) {
      scaling.deviation[i] += std::pow(sample->features[i] - scaling.mean[i], 2);
    }
    scaling.deviation[i] = std::sqrt(scaling.deviation[i] / num_samples);
    if (scaling.deviation[i] <= 0.0) scaling.deviation[i] = 1.0;
  }
  return scaling;
}

void Scale(const std::vector<float>& features, const Scaling& scaling, float* row) {
  for (size_t i = 0; i < features.size(); ++i) {
    row[i] = static_cast<float>((features[i] - scaling.mean[i]) / scaling.deviation[i]);
  }
}

cv::Ptr<cv::ml::ANN_MLP> EmptyNetwork(int num_features,
                                      int num_hidden,
                                      const PerceptronOptions& options) {
  const cv::Ptr<cv::ml::ANN_MLP> network = cv::ml::ANN_MLP::create();
  network->setLayerSizes(std::vector<int>{num_features, num_hidden, 1});
  network->setActivationFunction(cv::ml::ANN_MLP::SIGMOID_SYM, 0.0, 0.0);
  network->setTrainMethod(cv::ml::ANN_MLP::RPROP);
  network->setTermCriteria({cv::TermCriteria::MAX_ITER, options.max_num_iterations, 0.0});
  return network;
}

Predictor TrainPerceptron(const SamplePointers& samples,
                          int num_hidden,
                          const PerceptronOptions& options) {
  const Scaling scaling = ScalingOf(samples);
  const auto num_features = static_cast<int>(scaling.mean.size());
  cv::Mat1f rows(static_cast<int>(samples.size()), num_features);
  cv::Mat1f outputs(rows.rows, 1);
  for (int i = 0; i < rows.rows; ++i) {
    const TrainingSample& sample = *samples[static_cast<size_t>(i)];
    Scale(sample.features, scaling, rows[i]);
    outputs(i, 0) = sample.is_grass ? kGrassOutput : kOtherOutput;
  }
  const cv::Ptr<cv::ml::ANN_MLP> network = EmptyNetwork(num_features, num_hidden, options);
  const SeededRng seeded(options.seed);
  // The inputs are scaled already; scaled outputs would not be symmetric.
  network->train(cv::ml::TrainData::create(rows, cv::ml::ROW_SAMPLE, outputs),
                 cv::ml::ANN_MLP::NO_INPUT_SCALE | cv::ml::ANN_MLP::NO_OUTPUT_SCALE);
  return [network, scaling](const std::vector<float>& features) {
    cv::Mat1f row(1, static_cast<int>(features.size())), output;
    Scale(features, scaling, row[0]);
    network->predict(row, output);
    return (output(0, 0) - kOtherOutput) / (kGrassOutput - kOtherOutput);
  };
}

Learner PerceptronLearner(int num_hidden, const PerceptronOptions& options) {
  return [num_hidden, &options](const SamplePointers& samples) {
    return TrainPerceptron(samples, num_hidden, options);
  };
}

}  // namespace

void PerceptronOptions::Check() const {
  if (nums_hidden.empty() || *std::min_element(nums_hidden.begin(), nums_hidden.end()) < 1) {
    throw std::invalid_argument("perceptron.nums_hidden: must hold numbers >= 1");
  }
  if (max_num_iterations < 1) {
    throw std::invalid_argument(
        "perceptron.max_num_iterations = " + std::to_string(max_num_iterations) + ": must be >= 1");
  }
  if (num_folds < 2) {
    throw std::invalid_argument("perceptron.num_folds = " + std::to_string(num_folds) +
                                ": must be >= 2");
  }
}

PerceptronReport ValidatePerceptron(const std::vector<TrainingSample>& samples,
                                    const PerceptronOptions& options) {
  options.Check();
  if (samples.empty()) throw std::invalid_argument("perceptron: no samples");
  const std::vector<int> folds = RandomFolds(samples.size(), options.num_folds, options.seed);
  PerceptronReport report;
  report.random_fold_error_ratio = std::numeric_limits<double>::infinity();
  for (const int num_hidden : options.nums_hidden) {
    const std::vector<Prediction> random =
        CrossValidate(samples, folds, PerceptronLearner(num_hidden, options));
    const double error = ErrorRatio(random);
    if (error >= report.random_fold_error_ratio) continue;
    report.num_hidden = num_hidden;
    report.random_fold_error_ratio = error;
    report.random_fold_auc = AreaUnderCurve(random);
  }
  const std::vector<Prediction> by_place =
      CrossValidate(samples, FoldsByPlace(samples), PerceptronLearner(report.num_hidden, options));
  report.leave_one_place_out_error_ratio = ErrorRatio(by_place);
  report.leave_one_place_out_auc = AreaUnderCurve(by_place);
  return report;
}

}  // namespace freelsd
