#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "engine/classification/classification.h"
#include "engine/classification/model.h"
#include "engine/classification/validation.h"

namespace freelsd {
namespace {

struct ForestSettings {
  int max_depth = 0;
  int min_samples = 0;
};

cv::Ptr<cv::ml::RTrees> TrainForest(const SamplePointers& samples,
                                    const ForestSettings& settings,
                                    const TrainingOptions& options) {
  const size_t num_features = NumFeatures(options.feature_set);
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
  size_t num_grass = 0;
  for (const TrainingSample& sample : samples) {
    if (sample.features.size() != num_features) {
      throw std::invalid_argument("training: a sample has " +
                                  std::to_string(sample.features.size()) + " features, not " +
                                  std::to_string(num_features));
    }
    num_grass += sample.is_grass ? 1 : 0;
  }
  if (num_grass == 0 || num_grass == samples.size()) {
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
  const std::vector<int> folds = RandomFolds(samples.size(), options.num_folds, options.seed);
  const ForestSettings settings = BestSettings(samples, folds, options);
  const Learner learner = ForestLearner(settings, options);
  const std::vector<Prediction> by_place = CrossValidate(samples, FoldsByPlace(samples), learner);
  const std::vector<Prediction> random = CrossValidate(samples, folds, learner);
  auto model = std::make_shared<Classifier::Model>();
  model->feature_set = options.feature_set;
  model->provenance = provenance;
  SamplePointers all;
  for (const TrainingSample& sample : samples) all.push_back(&sample);
  model->forest = TrainForest(all, settings, options);
  return {Classifier(std::move(model)), ReportOf(settings, random, by_place)};
}

}  // namespace freelsd
