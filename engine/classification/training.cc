#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

#include <Eigen/LU>

#include "engine/classification/classification.h"
#include "engine/classification/features.h"
#include "engine/classification/model.h"
#include "engine/classification/validation.h"

namespace freelsd {
namespace {

// Leaving one place out needs another.
constexpr int kMinPlacesToLeaveOneOut = 2;

// Share of the training grass that a feature's range ignores at either end.
constexpr double kRareGrassRatio = 0.002;

struct ForestSettings {
  int max_depth = 0;
  int min_samples = 0;
};

cv::Ptr<cv::ml::RTrees> TrainForest(const SamplePointers& samples,
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

// Votes of forests with these settings.
Learner ForestLearner(const ForestSettings& settings, const TrainingOptions& options) {
  return [&settings, &options](const SamplePointers& samples) -> Predictor {
    return [forest = TrainForest(samples, settings, options)](const std::vector<float>& features) {
      return GrassVotes(*forest, features);
    };
  };
}

// Fits a logistic curve to the out-of-fold votes by Newton, with Platt's smoothed targets (1999).
Calibration FitCalibration(const std::vector<Prediction>& predictions) {
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

// Samples of too few places are split into random folds.
std::vector<int> PlaceFolds(const std::vector<TrainingSample>& samples,
                            const TrainingOptions& options) {
  std::vector<int> folds = FoldsByPlace(samples);
  const int num_places = *std::max_element(folds.begin(), folds.end()) + 1;
  if (num_places >= kMinPlacesToLeaveOneOut) return folds;
  return RandomFolds(samples.size(), options.num_folds, options.seed);
}

ForestSettings BestSettings(const std::vector<TrainingSample>& samples,
                            const std::vector<int>& folds,
                            const TrainingOptions& options) {
  ForestSettings best{options.max_depths.front(), options.min_samples_per_branch.front()};
  double best_error = std::numeric_limits<double>::infinity();
  for (const int max_depth : options.max_depths) {
    for (const int min_samples : options.min_samples_per_branch) {
      const ForestSettings settings{max_depth, min_samples};
      const double error =
          ErrorRatio(CrossValidate(samples, folds, ForestLearner(settings, options)));
      if (error < best_error) {
        best_error = error;
        best = settings;
      }
    }
  }
  return best;
}

TrainingReport ReportOf(const ForestSettings& settings,
                        const std::vector<Prediction>& random,
                        const std::vector<Prediction>& by_place) {
  TrainingReport report;
  report.max_depth = settings.max_depth;
  report.min_samples_per_branch = settings.min_samples;
  report.random_fold_error_ratio = ErrorRatio(random);
  report.random_fold_auc = AreaUnderCurve(random);
  report.leave_one_place_out_error_ratio = ErrorRatio(by_place);
  report.leave_one_place_out_auc = AreaUnderCurve(by_place);
  return report;
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
  const bool is_published = options.form == TrainingForm::kPublished;
  // Without augmented samples, whose originals would be in another fold.
  const std::vector<TrainingSample> originals = Originals(samples);
  const std::vector<int> random_folds =
      RandomFolds(originals.size(), options.num_folds, options.seed);
  const std::vector<int> place_folds = PlaceFolds(samples, options);
  const ForestSettings settings = is_published ? BestSettings(originals, random_folds, options)
                                               : BestSettings(samples, place_folds, options);
  const Learner learner = ForestLearner(settings, options);
  const std::vector<Prediction> by_place = CrossValidate(samples, place_folds, learner);
  const std::vector<Prediction> random = CrossValidate(originals, random_folds, learner);
  auto model = std::make_shared<Classifier::Model>();
  model->feature_set = options.feature_set;
  model->provenance = provenance;
  if (!is_published) {
    model->calibration = FitCalibration(by_place);
    SetGrassRange(originals, *model);
  }
  SamplePointers all;
  for (const TrainingSample& sample : samples) all.push_back(&sample);
  model->forest = TrainForest(all, settings, options);
  return {Classifier(std::move(model)), ReportOf(settings, random, by_place)};
}

}  // namespace freelsd
