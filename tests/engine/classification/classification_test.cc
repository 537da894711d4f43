#include "engine/classification/classification.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

namespace freelsd {
namespace {

constexpr double kSamplingM = 0.3;

// A surface of the given colour, unevenly lit.
cv::Mat3b Ground(const cv::Vec3b& bgr) {
  constexpr double kDeviationGrey = 6.0;
  cv::Mat3s noise(120, 160);
  cv::RNG generator(11);
  generator.fill(noise, cv::RNG::NORMAL, 0.0, kDeviationGrey);
  cv::Mat3b image(noise.size());
  cv::add(cv::Mat3b(noise.size(), bgr), noise, image, cv::noArray(), CV_8U);
  return image;
}

Segments WholeImage(const cv::Mat3b& image) {
  Segments segments;
  segments.image = segments.detail_image = image;
  segments.labels = cv::Mat1i(image.size(), 1);
  segments.ground_sampling_distance_m = segments.detail_sampling_distance_m = kSamplingM;
  Segment segment;
  segment.label = 1;
  segments.segments.push_back(segment);
  return segments;
}

std::vector<TrainingSample> Samples(int num_per_place) {
  std::vector<TrainingSample> samples;
  cv::RNG generator(5);
  for (const char* place : {"a", "b", "c"}) {
    for (int i = 0; i < num_per_place; ++i) {
      TrainingSample sample;
      sample.is_grass = i % 2 == 0;
      sample.place = place;
      sample.features.assign(6, 0.0f);
      for (float& feature : sample.features) feature = static_cast<float>(generator.gaussian(1.0));
      sample.features[1] += sample.is_grass ? 4.0f : -4.0f;
      samples.push_back(sample);
    }
  }
  return samples;
}

TrainingOptions SmallTraining() {
  TrainingOptions options;
  options.feature_set = FeatureSet::kRgb;
  options.max_depths = {3};
  options.min_samples_per_branch = {4};
  options.num_trees = 20;
  return options;
}

TEST_CASE("classification: feature rows have their length and see the mask only") {
  cv::Mat3b image = Ground({60, 130, 90});
  cv::Mat1b mask(image.size(), uint8_t{0});
  mask(cv::Rect(40, 40, 50, 50)) = 255;
  const std::pair<FeatureSet, size_t> sets[] = {{FeatureSet::kRgb, 6},
                                                {FeatureSet::kHsv, 6},
                                                {FeatureSet::kRgbHsv, 12},
                                                {FeatureSet::kPaper18, 18}};
  for (const auto& [set, size] : sets) {
    const std::vector<float> row = RegionFeatures(image, mask, set);
    CHECK(row.size() == size);
    CHECK(NumFeatures(set) == size);
    for (const float feature : row) CHECK(std::isfinite(feature));
    CHECK(FeatureSetNamed(NameOf(set)) == set);
    if (set == FeatureSet::kPaper18) continue;  // filters reach beyond the mask
    cv::Mat3b painted = image.clone();
    painted.setTo(cv::Scalar(0, 0, 255), mask == 0);
    CHECK(RegionFeatures(painted, mask, set) == row);
  }
}

TEST_CASE("classification: hue is circular, and means and deviations are those of the colours") {
  cv::Mat3b image(20, 20, cv::Vec3b(0, 10, 200));
  image(cv::Rect(0, 0, 10, 20)) = cv::Vec3b(10, 0, 200);
  const cv::Mat1b mask(image.size(), uint8_t{255});
  const std::vector<float> hsv = RegionFeatures(image, mask, FeatureSet::kHsv);
  constexpr float kHueToleranceDeg = 0.5f;
  // Hues of +3 and -3 deg: the mean is 0 or 360, not 180.
  CHECK(std::min(hsv[0], 360.0f - hsv[0]) < kHueToleranceDeg);
  CHECK(std::abs(hsv[1] - 3.0f) < kHueToleranceDeg);
  const std::vector<float> rgb = RegionFeatures(image, mask, FeatureSet::kRgb);
  CHECK(rgb[0] == doctest::Approx(200.0));
  CHECK(rgb[1] == doctest::Approx(0.0));
  CHECK(rgb[2] == doctest::Approx(5.0));
  CHECK(rgb[3] == doctest::Approx(5.0));
}

TEST_CASE("classification: segments are told by their features, and infrared is unsure") {
  std::vector<TrainingSample> samples;
  const cv::Mat1b mask(120, 160, uint8_t{255});
  for (int i = 0; i < 40; ++i) {
    const bool is_grass = i % 2 == 0;
    const cv::Vec3b bgr = is_grass ? cv::Vec3b(60, 140, 90) : cv::Vec3b(120, 110, 120);
    samples.push_back({RegionFeatures(Ground(bgr), mask, FeatureSet::kRgb), is_grass, "a"});
  }
  const Classifier classifier = TrainClassifier(samples, "test data", SmallTraining()).first;
  const auto surface_of = [&](const cv::Vec3b& bgr) {
    return ClassifySegments(WholeImage(Ground(bgr)), classifier, {}).at(0).surface;
  };
  CHECK(surface_of({60, 140, 90}) == Surface::kGrass);
  CHECK(surface_of({120, 110, 120}) == Surface::kNotGrass);
  CHECK(surface_of({80, 70, 170}) == Surface::kUnsure);
}

TEST_CASE("classification: training is deterministic and leaves OpenCV's generator alone") {
  const std::vector<TrainingSample> samples = Samples(40);
  cv::theRNG() = cv::RNG(99);
  const auto [first, report] = TrainClassifier(samples, "test data", SmallTraining());
  CHECK(cv::theRNG().state == cv::RNG(99).state);
  cv::theRNG() = cv::RNG(1234);
  const auto [second, ignored] = TrainClassifier(samples, "test data", SmallTraining());
  CHECK(first.Serialize() == second.Serialize());
  CHECK(report.leave_one_place_out_error_ratio < 0.05);
  CHECK(report.leave_one_place_out_auc > 0.95);
  CHECK(report.max_depth == 3);
}

TEST_CASE("classification: a model survives being written and read") {
  const Classifier trained = TrainClassifier(Samples(40), "test data", SmallTraining()).first;
  const Classifier read = Classifier::Parse(trained.Serialize());
  CHECK(read.provenance() == "test data");
  CHECK(read.feature_set() == FeatureSet::kRgb);
  for (const TrainingSample& sample : Samples(10)) {
    CHECK(read.Predict(sample.features) == doctest::Approx(trained.Predict(sample.features)));
    CHECK((read.Predict(sample.features) > 0.5) == sample.is_grass);
  }
  CHECK_THROWS_AS(read.Predict({1.0f}), std::invalid_argument);
}

TEST_CASE("classification: text that is no model is refused") {
  CHECK_THROWS_AS(Classifier::Parse(""), std::invalid_argument);
  CHECK_THROWS_AS(Classifier::Parse("no model"), std::invalid_argument);
  CHECK_THROWS_AS(Classifier::Parse("%YAML:1.0\n---\nversion: 99\n"), std::invalid_argument);
  const std::string text =
      TrainClassifier(Samples(20), "test data", SmallTraining()).first.Serialize();
  // Of an earlier form.
  CHECK_THROWS_AS(
      Classifier::Parse(std::string(text).replace(text.find("version: 2"), 10, "version: 1")),
      std::invalid_argument);
  // Cut anywhere within the forest.
  for (size_t tenths = 3; tenths < 10; ++tenths) {
    CHECK_THROWS_AS(Classifier::Parse(text.substr(0, text.size() * tenths / 10)),
                    std::invalid_argument);
  }
}

TEST_CASE("classification: samples of one kind, of another length, and bad options are refused") {
  std::vector<TrainingSample> samples = Samples(10);
  for (TrainingSample& sample : samples) sample.is_grass = true;
  CHECK_THROWS_AS(TrainClassifier(samples, "", SmallTraining()), std::invalid_argument);
  samples = Samples(10);
  samples[3].features.pop_back();
  CHECK_THROWS_AS(TrainClassifier(samples, "", SmallTraining()), std::invalid_argument);
  TrainingOptions training;
  training.num_folds = 1;
  CHECK_THROWS_AS(training.Check(), std::invalid_argument);
  ClassificationOptions options;
  options.min_grass_probability = 0.3;
  CHECK_THROWS_AS(options.Check(), std::invalid_argument);
  options = {};
  options.max_not_grass_probability = 0.7;
  CHECK_THROWS_AS(options.Check(), std::invalid_argument);
  CHECK_FALSE(FeatureSetNamed("magic"));
}

}  // namespace
}  // namespace freelsd
