#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include <Eigen/LU>

#include "engine/classification/classification.h"
#include "engine/classification/features.h"
#include "engine/classification/model.h"

namespace freelsd {
namespace {

// Samples of fewer places are split into random folds.
constexpr int kMinPlacesToLeaveOneOut = 2;

// Share of the training grass that a feature's range ignores at either end.
constexpr double kRareGrassRatio = 0.002;

using Samples = std::vector<const TrainingSample*>;

struct ForestSettings {
  int max_depth = 0;
  int min_samples = 0;
};

// The forest uses OpenCV's generator of this thread: seeded here and restored afterwards.
class SeededRng {
 public:
  explicit SeededRng(int seed) : saved_(cv::theRNG()) {
    cv::theRNG() = cv::RNG(static_cast<uint64_t>(seed));
  }
  ~SeededRng() { cv::theRNG() = saved_; }
  SeededRng(const SeededRng&) = delete;
  SeededRng& operator=(const SeededRng&) = delete;

 private:
  cv::RNG saved_;
};

cv::Ptr<cv::ml::RTrees> TrainForest(const Samples& samples,
                                    const ForestSettings& settings,
                                    const TrainingOptions& options) {
  const size_t num_features = NumForestFeatures(options.feature_set);
  cv::Mat1f rows(static_cast<int>(samples.size()), static_cast<int>(num_features));
  cv::Mat1i labels(static_cast<int>(samples.size()), 1);
  for (int i = 0; i < rows.rows; ++i) {
    const TrainingSample& sample = *samples[static_cast<size_t>(i)];
    std::copy_n(sample.features.begin(), num_features, rows[i]);
    labels(i, 0) = sample.is_grass ? 1 : 0;
  }
  const cv::Ptr<cv::ml::RTrees> forest = cv::ml::RTrees::create();
  forest->setMaxDepth(settings.max_depth);
  forest->setMinSampleCount(settings.min_samples);
  forest->setActiveVarCount(0);
  forest->setTermCriteria({cv::TermCriteria::MAX_ITER, options.num_trees, 0.0});
  const SeededRng seeded(options.seed);
  forest->train(cv::ml::TrainData::create(rows, cv::ml::ROW_SAMPLE, labels));
  return forest;
}

bool HasBothKinds(const Samples& samples) {
  const auto is_grass = [](const TrainingSample* sample) { return sample->is_grass; };
  return std::any_of(samples.begin(), samples.end(), is_grass) &&
         !std::all_of(samples.begin(), samples.end(), is_grass);
}

struct Prediction {
  double votes = 0.0;
  bool is_grass = false;
};

// Votes for every sample that is not augmented, from a forest trained on the other folds.
std::vector<Prediction> CrossValidate(const std::vector<TrainingSample>& samples,
                                      const std::vector<int>& fold_of_sample,
                                      const ForestSettings& settings,
                                      const TrainingOptions& options) {
  std::vector<Prediction> predictions;
  const std::set<int> folds(fold_of_sample.begin(), fold_of_sample.end());
  for (const int fold : folds) {
    Samples training;
    for (size_t i = 0; i < samples.size(); ++i) {
      if (fold_of_sample[i] != fold) training.push_back(&samples[i]);
    }
    // Training needs both kinds.
    if (!HasBothKinds(training)) continue;
    const cv::Ptr<cv::ml::RTrees> forest = TrainForest(training, settings, options);
    for (size_t i = 0; i < samples.size(); ++i) {
      if (fold_of_sample[i] != fold || samples[i].is_augmented) continue;
      predictions.push_back({GrassVotes(*forest, samples[i].features), samples[i].is_grass});
    }
  }
  return predictions;
}

double ErrorRatio(const std::vector<Prediction>& predictions) {
  const auto num_wrong =
      std::count_if(predictions.begin(), predictions.end(), [](const Prediction& prediction) {
        return (prediction.votes >= 0.5) != prediction.is_grass;
      });
  return static_cast<double>(num_wrong) / static_cast<double>(predictions.size());
}

// Area under the ROC curve: share of (grass, not grass) pairs in the right order; ties count half.
double AreaUnderCurve(const std::vector<Prediction>& predictions) {
  double right = 0.0, all = 0.0;
  for (const Prediction& grass : predictions) {
    if (!grass.is_grass) continue;
    for (const Prediction& other : predictions) {
      if (other.is_grass) continue;
      all += 1.0;
      if (grass.votes > other.votes) right += 1.0;
      if (grass.votes == other.votes) right += 0.5;
    }
  }
  return all > 0.0 ? right / all : std::numeric_limits<double>::quiet_NaN();
}

std::vector<int> RandomFolds(size_t num_samples, const TrainingOptions& options) {
  std::vector<int> folds(num_samples);
  for (size_t i = 0; i < num_samples; ++i) {
    folds[i] = static_cast<int>(i % static_cast<size_t>(options.num_folds));
  }
  std::mt19937 generator(static_cast<unsigned>(options.seed));
  // Fisher-Yates by hand: std::shuffle differs between standard libraries.
  for (size_t i = num_samples; i > 1; --i) std::swap(folds[i - 1], folds[generator() % i]);
  return folds;
}

std::vector<int> FoldsByPlace(const std::vector<TrainingSample>& samples) {
  std::map<std::string, int> fold_of_place;
  std::vector<int> folds;
  folds.reserve(samples.size());
  for (const TrainingSample& sample : samples) {
    folds.push_back(
        fold_of_place.emplace(sample.place, static_cast<int>(fold_of_place.size())).first->second);
  }
  return folds;
}

// Fits a logistic curve to the out-of-fold votes by Newton, with Platt's smoothed targets (1999).
std::pair<double, double> FitCalibration(const std::vector<Prediction>& predictions) {
  const double num_grass = static_cast<double>(std::count_if(
      predictions.begin(), predictions.end(), [](const auto& p) { return p.is_grass; }));
  const double num_other = static_cast<double>(predictions.size()) - num_grass;
  const double grass_target = (num_grass + 1.0) / (num_grass + 2.0);
  const double other_target = 1.0 / (num_other + 2.0);
  Eigen::Vector2d parameters(4.0, -2.0);
  constexpr int kNumNewtonSteps = 50;
  constexpr double kDamping = 1e-3;
  for (int step = 0; step < kNumNewtonSteps; ++step) {
    Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
    Eigen::Matrix2d hessian = kDamping * Eigen::Matrix2d::Identity();
    for (const Prediction& prediction : predictions) {
      const Eigen::Vector2d x(prediction.votes, 1.0);
      const double probability = 1.0 / (1.0 + std::exp(-parameters.dot(x)));
      gradient += (probability - (prediction.is_grass ? grass_target : other_target)) * x;
      hessian += probability * (1.0 - probability) * x * x.transpose();
    }
    const double determinant = hessian.determinant();
    const Eigen::Matrix2d adjugate{{hessian(1, 1), -hessian(0, 1)},
                                   {-hessian(1, 0), hessian(0, 0)}};
    parameters -= adjugate * gradient / determinant;
  }
  return {parameters[0], parameters[1]};
}

// Uses original samples only, because augmented copies show what no camera would. Drops the rarest
// share at either end, because labels have errors.
void SetGrassRange(const std::vector<TrainingSample>& originals, Classifier::Model& model) {
  const size_t num_features = NumFeatures(model.feature_set);
  for (size_t i = 0; i < num_features; ++i) {
    std::vector<float> values;
    for (const TrainingSample& sample : originals) {
      if (sample.is_grass) values.push_back(sample.features[i]);
    }
    std::sort(values.begin(), values.end());
    const auto num_rare = static_cast<size_t>(kRareGrassRatio * static_cast<double>(values.size()));
    model.grass_min.push_back(values[num_rare]);
    model.grass_max.push_back(values[values.size() - 1 - num_rare]);
  }
}

std::vector<TrainingSample> Originals(const std::vector<TrainingSample>& samples) {
  std::vector<TrainingSample> originals;
  std::copy_if(samples.begin(),
               samples.end(),
               std::back_inserter(originals),
               [](const TrainingSample& sample) { return !sample.is_augmented; });
  return originals;
}

ForestSettings BestSettings(const std::vector<TrainingSample>& samples,
                            const std::vector<int>& folds,
                            const TrainingOptions& options) {
  ForestSettings best{options.max_depths.front(), options.min_samples_per_branch.front()};
  double best_error = std::numeric_limits<double>::infinity();
  for (const int max_depth : options.max_depths) {
    for (const int min_samples : options.min_samples_per_branch) {
      const ForestSettings settings{max_depth, min_samples};
      const double error = ErrorRatio(CrossValidate(samples, folds, settings, options));
      if (error < best_error) {
        best_error = error;
        best = settings;
      }
    }
  }
  return best;
}

void CheckSamples(const std::vector<TrainingSample>& samples, const TrainingOptions& options) {
  options.Check();
  const size_t num_features = NumFeatures(options.feature_set);
  size_t num_grass = 0, num_originals = 0;
  for (const TrainingSample& sample : samples) {
    if (sample.features.size() != num_features) {
      throw std::invalid_argument("training: a sample has " +
                                  std::to_string(sample.features.size()) + " features, not " +
                                  std::to_string(num_features));
    }
    if (sample.is_augmented) continue;
    ++num_originals;
    num_grass += sample.is_grass ? 1 : 0;
  }
  if (num_grass == 0 || num_grass == num_originals) {
    throw std::invalid_argument("training: samples of grass and of other surfaces are needed");
  }
}

}  // namespace

void TrainingOptions::Check() const {
  if (max_depths.empty()) throw std::invalid_argument("training.max_depths: must not be empty");
  if (min_samples_per_branch.empty()) {
    throw std::invalid_argument("training.min_samples_per_branch: must not be empty");
  }
  if (num_trees < 1) {
    throw std::invalid_argument("training.num_trees = " + std::to_string(num_trees) +
                                ": must be >= 1");
  }
  if (num_folds < 2) {
    throw std::invalid_argument("training.num_folds = " + std::to_string(num_folds) +
                                ": must be >= 2");
  }
}

std::pair<Classifier, TrainingReport> TrainClassifier(const std::vector<TrainingSample>& samples,
                                                      const std::string& provenance,
                                                      const TrainingOptions& options) {
  CheckSamples(samples, options);
  const std::vector<int> place_folds = FoldsByPlace(samples);
  const int num_places = *std::max_element(place_folds.begin(), place_folds.end()) + 1;
  const std::vector<int> folds =
      num_places < kMinPlacesToLeaveOneOut ? RandomFolds(samples.size(), options) : place_folds;
  const ForestSettings settings = BestSettings(samples, folds, options);
  const std::vector<Prediction> by_place = CrossValidate(samples, folds, settings, options);
  // Without augmented samples, whose originals would be in another fold.
  const std::vector<TrainingSample> originals = Originals(samples);
  const std::vector<Prediction> random =
      CrossValidate(originals, RandomFolds(originals.size(), options), settings, options);
  TrainingReport report;
  report.max_depth = settings.max_depth;
  report.min_samples_per_branch = settings.min_samples;
  report.random_fold_error_ratio = ErrorRatio(random);
  report.leave_one_place_out_error_ratio = ErrorRatio(by_place);
  report.leave_one_place_out_auc = AreaUnderCurve(by_place);
  auto model = std::make_shared<Classifier::Model>();
  model->feature_set = options.feature_set;
  model->provenance = provenance;
  std::tie(model->calibration_slope, model->calibration_offset) = FitCalibration(by_place);
  SetGrassRange(originals, *model);
  Samples all;
  for (const TrainingSample& sample : samples) all.push_back(&sample);
  model->forest = TrainForest(all, settings, options);
  return {Classifier(std::move(model)), report};
}

}  // namespace freelsd
