// Training as the paper does: forest and perceptron, chosen by ten random folds.
#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "engine/classification/classification.h"
#include "engine/classification/validation.h"

namespace freelsd {
namespace {

// Grass and the rest overlap in one feature. Every place is shifted by its own amount, so a place
// that was not seen is harder.
std::vector<TrainingSample> Samples(double shift) {
  std::vector<TrainingSample> samples;
  cv::RNG generator(7);
  for (int place = 0; place < 3; ++place) {
    for (int i = 0; i < 60; ++i) {
      TrainingSample sample;
      sample.is_grass = i % 2 == 0;
      sample.place = std::to_string(place);
      sample.features.assign(6, 0.0f);
      for (float& feature : sample.features) feature = static_cast<float>(generator.gaussian(1.0));
      sample.features[1] += static_cast<float>((sample.is_grass ? 3.0 : -3.0) + shift * place);
      samples.push_back(sample);
    }
  }
  return samples;
}

TrainingOptions SmallTraining() {
  TrainingOptions options;
  options.feature_set = FeatureSet::kRgb;
  options.max_depths = {2, 6};
  options.min_samples_per_branch = {2, 10};
  options.num_trees = 15;
  return options;
}

TEST_CASE("training: ten folds of equal size hold every sample once") {
  const std::vector<int> folds = RandomFolds(95, 10, 1);
  REQUIRE(folds.size() == 95);
  for (int fold = 0; fold < 10; ++fold) {
    const auto size = std::count(folds.begin(), folds.end(), fold);
    CHECK((size == 9 || size == 10));
  }
  CHECK(RandomFolds(95, 10, 1) == folds);
  CHECK(RandomFolds(95, 10, 2) != folds);
}

TEST_CASE("training: cross-validation never predicts a sample that was learnt from") {
  const std::vector<TrainingSample> samples = Samples(0.0);
  size_t num_predicted = 0;
  const Learner learner = [&](const SamplePointers& training) -> Predictor {
    std::set<std::vector<float>> known;
    for (const TrainingSample* sample : training) known.insert(sample->features);
    return [known, &num_predicted](const std::vector<float>& features) {
      ++num_predicted;
      CHECK_FALSE(known.contains(features));
      return 1.0;
    };
  };
  const std::vector<Prediction> predictions =
      CrossValidate(samples, RandomFolds(samples.size(), 10, 1), learner);
  CHECK(num_predicted == samples.size());
  CHECK(ErrorRatio(predictions) == doctest::Approx(0.5));
  CHECK(AreaUnderCurve(predictions) == doctest::Approx(0.5));
}

TEST_CASE("training: the probability is the share of votes, whatever the features") {
  const auto [classifier, report] = TrainClassifier(Samples(0.0), "test data", SmallTraining());
  CHECK(report.random_fold_error_ratio < 0.05);
  CHECK(report.random_fold_auc > 0.95);
  const Classifier read = Classifier::Parse(classifier.Serialize());
  for (const float value : {-1e6f, -1.0f, 1.0f, 1e6f}) {
    const std::vector<float> features(6, value);
    CHECK(read.Predict(features) == classifier.Predict(features));
    const double votes = 15.0 * read.Predict(features);
    CHECK(votes == doctest::Approx(std::round(votes)));
  }
  // Grass far beyond the range of the training is still called grass.
  CHECK(read.Predict({0.0f, 1e6f, 0.0f, 0.0f, 0.0f, 0.0f}) >= 0.5);
}

TEST_CASE("training: random folds hide that a place was never seen") {
  const TrainingReport report = TrainClassifier(Samples(6.0), "test data", SmallTraining()).second;
  CHECK(report.leave_one_place_out_error_ratio > report.random_fold_error_ratio + 0.1);
}

TEST_CASE("training: one place alone has no score of a place that was never seen") {
  std::vector<TrainingSample> samples = Samples(0.0);
  for (TrainingSample& sample : samples) sample.place = "a";
  const TrainingReport report = TrainClassifier(samples, "test data", SmallTraining()).second;
  CHECK(report.random_fold_error_ratio < 0.05);
  CHECK(std::isnan(report.leave_one_place_out_error_ratio));
  CHECK(std::isnan(report.leave_one_place_out_auc));
}

TEST_CASE("training: the perceptron learns what can be told, and always the same") {
  const PerceptronReport report = ValidatePerceptron(Samples(0.0), PerceptronOptions{});
  CHECK(report.random_fold_error_ratio < 0.05);
  CHECK(report.random_fold_auc > 0.95);
  CHECK(report.leave_one_place_out_error_ratio < 0.05);
  cv::theRNG() = cv::RNG(99);
  const PerceptronReport again = ValidatePerceptron(Samples(0.0), PerceptronOptions{});
  CHECK(cv::theRNG().state == cv::RNG(99).state);
  CHECK(again.num_hidden == report.num_hidden);
  CHECK(again.random_fold_auc == report.random_fold_auc);
}

TEST_CASE("training: bad options of the perceptron are named") {
  PerceptronOptions options;
  options.nums_hidden = {};
  CHECK_THROWS_AS(options.Check(), std::invalid_argument);
  options = {};
  options.num_folds = 1;
  CHECK_THROWS_WITH_AS(
      options.Check(), "perceptron.num_folds = 1: must be >= 2", std::invalid_argument);
  CHECK_THROWS_AS(ValidatePerceptron({}, PerceptronOptions{}), std::invalid_argument);
}

}  // namespace
}  // namespace freelsd
