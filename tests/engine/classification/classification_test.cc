#include "engine/classification/classification.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include <doctest/doctest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

constexpr double kSamplingM = 0.3;
// Of features that must not depend on exposure, in their own unit.
constexpr float kExposureTolerance = 0.08f;

std::string TextOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

// The model that the service uses, found from this source file.
const Classifier& Shipped() {
  static const Classifier kClassifier = Classifier::Parse(TextOf(
      std::filesystem::path(FREELSD_TEST_SOURCE_DIR) / "engine/classification/grass_model.yml"));
  return kClassifier;
}

// How unevenly a surface is lit and grown: standard deviations of log brightness.
struct Texture {
  double pixels = 0.045;
  // Over about 3 m.
  double blotches = 0.03;
};

cv::Mat1f UnitNoise(const cv::Size& size, uint64_t seed, double sigma_px) {
  cv::Mat1f noise(size);
  cv::RNG generator(seed);
  generator.fill(noise, cv::RNG::NORMAL, 0.0, 1.0);
  if (sigma_px > 0.0) cv::GaussianBlur(noise, noise, {}, sigma_px);
  cv::Scalar mean, deviation;
  cv::meanStdDev(noise, mean, deviation);
  return noise / deviation[0];
}

// A surface of the given colour, as grass is uneven unless told otherwise.
cv::Mat3b Ground(const cv::Vec3b& bgr, const Texture& texture = {}) {
  const cv::Size size(160, 120);
  const cv::Mat1f pixels = UnitNoise(size, 11, 0.0), blotches = UnitNoise(size, 12, 1.5);
  cv::Mat3b image(size);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const double factor =
          std::exp(texture.pixels * pixels(y, x) + texture.blotches * blotches(y, x));
      for (int channel = 0; channel < 3; ++channel) {
        image(y, x)[channel] = cv::saturate_cast<uint8_t>(bgr[channel] * factor);
      }
    }
  }
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

Surface SurfaceOf(const cv::Mat3b& image) {
  return ClassifySegments(WholeImage(image), Shipped(), ClassificationOptions{}).at(0).surface;
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
                                                {FeatureSet::kPaper18, 18},
                                                {FeatureSet::kRobust, 6}};
  for (const auto& [set, size] : sets) {
    const std::vector<float> row = RegionFeatures(image, mask, kSamplingM, set);
    CHECK(row.size() == size);
    for (const float feature : row) CHECK(std::isfinite(feature));
    CHECK(FeatureSetNamed(NameOf(set)) == set);
    if (set == FeatureSet::kPaper18) continue;  // filters reach beyond the mask
    cv::Mat3b painted = image.clone();
    painted.setTo(cv::Scalar(0, 0, 255), mask == 0);
    CHECK(RegionFeatures(painted, mask, kSamplingM, set) == row);
  }
}

TEST_CASE("classification: hue is circular, and means and deviations are those of the colours") {
  cv::Mat3b image(20, 20, cv::Vec3b(0, 10, 200));
  image(cv::Rect(0, 0, 10, 20)) = cv::Vec3b(10, 0, 200);
  const cv::Mat1b mask(image.size(), uint8_t{255});
  const std::vector<float> hsv = RegionFeatures(image, mask, kSamplingM, FeatureSet::kHsv);
  constexpr float kHueToleranceDeg = 0.5f;
  // Hues of +3 and -3 deg: the mean is 0 or 360, not 180.
  CHECK(std::min(hsv[0], 360.0f - hsv[0]) < kHueToleranceDeg);
  CHECK(std::abs(hsv[1] - 3.0f) < kHueToleranceDeg);
  const std::vector<float> rgb = RegionFeatures(image, mask, kSamplingM, FeatureSet::kRgb);
  CHECK(rgb[0] == doctest::Approx(200.0));
  CHECK(rgb[1] == doctest::Approx(0.0));
  CHECK(rgb[2] == doctest::Approx(5.0));
  CHECK(rgb[3] == doctest::Approx(5.0));
}

TEST_CASE("classification: the robust features do not depend on exposure") {
  const cv::Mat3b image = Ground({60, 140, 100});
  cv::Mat3b dark;
  image.convertTo(dark, CV_8U, 0.6);
  const cv::Mat1b mask(image.size(), uint8_t{255});
  const auto bright_row = RegionFeatures(image, mask, kSamplingM, FeatureSet::kRobust);
  const auto dark_row = RegionFeatures(dark, mask, kSamplingM, FeatureSet::kRobust);
  for (size_t i = 0; i < bright_row.size(); ++i) {
    CHECK(std::abs(bright_row[i] - dark_row[i]) < kExposureTolerance);
  }
}

TEST_CASE("classification: a veil of air leaves the image of the features nearly as it was") {
  cv::Mat3b clear = Ground({60, 140, 100});
  // Shadow in a corner, 4 % of the photograph.
  clear(cv::Rect(0, 0, clear.cols / 5, clear.rows / 5)) = cv::Vec3b(4, 6, 5);
  cv::Mat3b veiled;
  cv::add(clear, cv::Scalar(40, 38, 36), veiled);
  const cv::Scalar got = cv::mean(ImageForFeatures(veiled, FeatureSet::kRobust));
  const cv::Scalar wanted = cv::mean(ImageForFeatures(clear, FeatureSet::kRobust));
  constexpr double kVeilToleranceGrey = 5.0;
  for (int channel = 0; channel < 3; ++channel) {
    CHECK(std::abs(got[channel] - wanted[channel]) < kVeilToleranceGrey);
  }
}

TEST_CASE("classification: a photograph without shadows has no veil to take off") {
  const cv::Mat3b image = Ground({60, 140, 100});
  CHECK(cv::norm(ImageForFeatures(image, FeatureSet::kRobust), image, cv::NORM_INF) == 0.0);
}

TEST_CASE("classification: an even green meadow is grass, in summer, spring and haze") {
  CHECK(SurfaceOf(Ground({60, 140, 100})) == Surface::kGrass);
  CHECK(SurfaceOf(Ground({50, 130, 95})) == Surface::kGrass);
  CHECK(SurfaceOf(Ground({85, 125, 115})) == Surface::kGrass);
  // Half the light.
  CHECK(SurfaceOf(Ground({30, 70, 50})) == Surface::kGrass);
}

TEST_CASE("classification: what looks like a field and is not, is not grass") {
  const auto is_grass = [](const cv::Vec3b& bgr, const Texture& texture = {}) {
    return SurfaceOf(Ground(bgr, texture)) == Surface::kGrass;
  };
  const Texture even{0.004, 0.004};
  SUBCASE("canopy: as green, with shadows between crowns") {
    CHECK_FALSE(is_grass({60, 140, 100}, {0.25, 0.2}));
  }
  SUBCASE("asphalt, sand, bare soil, roof tiles, leaf litter") {
    CHECK_FALSE(is_grass({130, 130, 130}));
    CHECK_FALSE(is_grass({150, 185, 205}));
    CHECK_FALSE(is_grass({80, 110, 140}));
    CHECK_FALSE(is_grass({60, 70, 150}));
    CHECK_FALSE(is_grass({95, 115, 140}));
  }
  SUBCASE("dark, muddy and blue-green water, still or with waves") {
    for (const Texture& texture : {even, Texture{}}) {
      CHECK_FALSE(is_grass({60, 55, 45}, texture));
      CHECK_FALSE(is_grass({140, 180, 205}, texture));
      CHECK_FALSE(is_grass({110, 115, 60}, texture));
      CHECK_FALSE(is_grass({120, 130, 50}, texture));
    }
  }
  SUBCASE("water with algae, even and green") { CHECK_FALSE(is_grass({50, 110, 80}, even)); }
  SUBCASE("one flat green without any texture, as of paint or a tarpaulin") {
    CHECK_FALSE(SurfaceOf(cv::Mat3b(120, 160, cv::Vec3b(60, 140, 100))) == Surface::kGrass);
  }
  SUBCASE("a glaring green that no meadow has") { CHECK_FALSE(is_grass({0, 220, 0})); }
}

TEST_CASE("classification: other light and other sensors make it unsure, not wrong") {
  SUBCASE("infrared false colour, where vegetation is red") {
    CHECK(SurfaceOf(Ground({80, 70, 170})) == Surface::kUnsure);
  }
  SUBCASE("a grey camera") { CHECK(SurfaceOf(Ground({110, 110, 110})) != Surface::kGrass); }
  SUBCASE("too dark, burnt out") {
    CHECK(SurfaceOf(Ground({8, 18, 12})) == Surface::kUnsure);
    CHECK(SurfaceOf(cv::Mat3b(120, 160, cv::Vec3b(250, 255, 253))) == Surface::kUnsure);
  }
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
  // Far from any grass of the training: at best unsure.
  CHECK(read.Predict({0.0f, 400.0f, 0.0f, 0.0f, 0.0f, 0.0f}) <= 0.5);
  CHECK_THROWS_AS(read.Predict({1.0f}), std::invalid_argument);
}

TEST_CASE("classification: text that is no model is refused") {
  CHECK_THROWS_AS(Classifier::Parse(""), std::invalid_argument);
  CHECK_THROWS_AS(Classifier::Parse("no model"), std::invalid_argument);
  CHECK_THROWS_AS(Classifier::Parse("%YAML:1.0\n---\nversion: 99\n"), std::invalid_argument);
  const std::string text =
      TrainClassifier(Samples(20), "test data", SmallTraining()).first.Serialize();
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

struct Flight {
  const char* folder;
  double focal_ratio;
  double height_m;
  bool has_grass;
};

TEST_CASE("classification: real flights have grass, and the infrared one none") {
  const char* data = std::getenv("FREELSD_DATA");
  if (data == nullptr) {
    MESSAGE("skipped: FREELSD_DATA is not set");
    return;
  }
  for (const Flight& flight : {Flight{"swindale", 0.70, 80.0, true},
                               Flight{"garfield_park", 0.7793, 110.0, true},
                               Flight{"brighton_beach", 0.5554, 40.0, true},
                               Flight{"seneca_nir", 0.722, 70.0, false}}) {
    int num_grass = 0;
    const auto folder = std::filesystem::path(data) / "flights" / flight.folder / "images";
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      const cv::Mat image =
          cv::imread(entry.path().string(), cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
      Camera camera;
      camera.width_px = image.cols;
      camera.height_px = image.rows;
      camera.fx_px = camera.fy_px = flight.focal_ratio * image.cols;
      const Segments segments = SegmentFrame(image, camera, flight.height_m, {});
      for (const Label& label : ClassifySegments(segments, Shipped(), {})) {
        num_grass += label.surface == Surface::kGrass ? 1 : 0;
      }
    }
    INFO(flight.folder);
    CHECK((num_grass > 0) == flight.has_grass);
  }
}

}  // namespace
}  // namespace freelsd
