#include "server/training/paper_training.h"

#include <utility>

namespace freelsd {
namespace {

using Json = nlohmann::ordered_json;

// A set of features, and its columns within paper18.
struct Columns {
  FeatureSet feature_set;
  std::ptrdiff_t begin;
  std::ptrdiff_t end;
};
constexpr Columns kColumns[] = {{FeatureSet::kRgb, 0, 6},
                                {FeatureSet::kHsv, 6, 12},
                                {FeatureSet::kRgbHsv, 0, 12},
                                {FeatureSet::kPaper18, 0, 18}};

std::vector<TrainingSample> Part(std::vector<TrainingSample> samples, const Columns& columns) {
  for (TrainingSample& sample : samples) {
    const std::vector<float> all = std::move(sample.features);
    sample.features.assign(all.begin() + columns.begin, all.begin() + columns.end);
  }
  return samples;
}

// TrainingReport or PerceptronReport.
template <class Report>
Json ScoresOf(const Report& report) {
  return {{"random_fold_error", report.random_fold_error_ratio},
          {"random_fold_auc", report.random_fold_auc},
          {"leave_one_place_out_error", report.leave_one_place_out_error_ratio},
          {"leave_one_place_out_auc", report.leave_one_place_out_auc}};
}

}  // namespace

std::vector<TrainingSample> PaperSamples(const Photographs& photographs) {
  constexpr double kMinLabelledRatio = 0.3;  // as in SamplesOf
  std::vector<TrainingSample> samples;
  for (const LabelledPhotograph& photograph : photographs) {
    const LabelledRegions regions = CutVaried(photograph, Variation{}, kMinLabelledRatio);
    for (TrainingSample& sample : RegionSamples(regions, FeatureSet::kPaper18)) {
      sample.place = photograph.place;
      samples.push_back(std::move(sample));
    }
  }
  return samples;
}

TrainingOptions PaperTraining(FeatureSet feature_set, int seed) {
  TrainingOptions options;
  options.form = TrainingForm::kPublished;
  options.feature_set = feature_set;
  options.max_depths = {2, 4, 6, 8, 12, 16};
  options.min_samples_per_branch = {2, 5, 10, 20, 40};
  options.num_trees = 31;  // odd: every vote has a majority
  options.seed = seed;
  return options;
}

Json PaperScores(const std::vector<TrainingSample>& samples, int seed) {
  Json scores;
  for (const Columns& columns : kColumns) {
    const TrainingReport report =
        TrainClassifier(Part(samples, columns), "", PaperTraining(columns.feature_set, seed))
            .second;
    Json& forest = scores["forest " + NameOf(columns.feature_set)];
    forest = ScoresOf(report);
    forest["max_depth"] = report.max_depth;
    forest["min_samples_per_branch"] = report.min_samples_per_branch;
  }
  PerceptronOptions options;
  options.seed = seed;
  const PerceptronReport report = ValidatePerceptron(samples, options);
  Json& perceptron = scores["perceptron paper18"];
  perceptron = ScoresOf(report);
  perceptron["num_hidden"] = report.num_hidden;
  return scores;
}

}  // namespace freelsd
