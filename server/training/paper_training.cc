#include "server/training/paper_training.h"

#include <utility>

#include <opencv2/imgproc.hpp>

#include "server/training/labelled_regions.h"

namespace freelsd {
namespace {

using Json = nlohmann::ordered_json;

// A region has the class of its majority if at least this share of its pixels is labelled.
constexpr double kMinLabelledRatio = 0.3;
// Smaller than the pipeline's least area, because small regions are useful samples too.
constexpr double kMinTrainingAreaM2 = 30.0;

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

// One sample for each region labelled as grass or not grass.
std::vector<TrainingSample> RegionSamples(const LabelledRegions& regions,
                                          const std::string& place) {
  const Segments& segments = regions.segments;
  std::vector<TrainingSample> samples;
  for (size_t i = 0; i < regions.classes.size(); ++i) {
    if (!TellsGrass(regions.classes[i])) continue;
    cv::Mat1b inside;
    cv::resize(segments.labels == segments.segments[i].label,
               inside,
               segments.detail_image.size(),
               0,
               0,
               cv::INTER_NEAREST);
    samples.push_back({RegionFeatures(segments.detail_image, inside, FeatureSet::kPaper18),
                       regions.classes[i] == kGrassClass,
                       place});
  }
  return samples;
}

}  // namespace

std::vector<TrainingSample> PaperSamples(const Photographs& photographs) {
  SegmentationOptions options;
  options.min_region_area_m2 = kMinTrainingAreaM2;
  std::vector<TrainingSample> samples;
  for (const LabelledPhotograph& photograph : photographs) {
    const LabelledRegions regions = CutPhotograph(photograph, options, kMinLabelledRatio);
    for (TrainingSample& sample : RegionSamples(regions, photograph.place)) {
      samples.push_back(std::move(sample));
    }
  }
  return samples;
}

Json PaperScores(const std::vector<TrainingSample>& samples, int seed) {
  Json scores;
  for (const Columns& columns : kColumns) {
    TrainingOptions options;
    options.feature_set = columns.feature_set;
    options.seed = seed;
    const TrainingReport report = TrainClassifier(Part(samples, columns), "", options).second;
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
