// Input: homogeneous regions. Output: the probability of grass of each. Paper: Sec. III-D.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/segmentation/segmentation.h"

namespace freelsd {

enum class FeatureSet {
  kRgb,      // 6: mean and deviation of R, G, B
  kHsv,      // 6: mean and deviation of H, S, V; hue is averaged as an angle
  kRgbHsv,   // 12: those of kRgb and kHsv
  kPaper18,  // 18: those of kRgbHsv, and mean and deviation of three Gabor responses (gabor.h)
};

struct ClassificationOptions {
  // --- Behaviour ---
  // A region is grass if its probability is at least min_grass_probability. It is not grass if its
  // probability is at most max_not_grass_probability. Between them it is unsure, and an unsure
  // region counts as not grass. Differs: the paper takes the majority of trees.
  double min_grass_probability = 0.7;
  double max_not_grass_probability = 0.4;

  void Check() const;
};

enum class Surface { kGrass, kNotGrass, kUnsure };

struct Label {
  // Probability of grass, 0..1. Of a Classifier, the share of the trees that vote for grass.
  double probability = 0.5;
  Surface surface = Surface::kUnsure;
};
// One per Segments::segments, same order.
using Labels = std::vector<Label>;

Surface SurfaceOf(double probability, const ClassificationOptions& options);

// A trained random forest and its feature set. Immutable, safe to share between threads.
class Classifier {
 public:
  // Parses the text that Serialize or freelsd-train wrote. Throws std::invalid_argument with the
  // reason if it is not a model.
  static Classifier Parse(const std::string& model_text);
  std::string Serialize() const;
  FeatureSet feature_set() const;
  // Free text in the model about its origin: data, licence, command, cross-validation.
  const std::string& provenance() const;
  // Probability of grass for one feature row.
  double Predict(const std::vector<float>& features) const;

  struct Model;
  explicit Classifier(std::shared_ptr<const Model> model);

 private:
  std::shared_ptr<const Model> model_;
};

// "rgb", "hsv", "rgbhsv", "paper18", as in models.
std::string NameOf(FeatureSet feature_set);
std::optional<FeatureSet> FeatureSetNamed(const std::string& name);
// Length of a feature row.
size_t NumFeatures(FeatureSet feature_set);

// Features of one region: only pixels where mask != 0. `image` is BGR.
std::vector<float> RegionFeatures(const cv::Mat3b& image,
                                  const cv::Mat1b& mask,
                                  FeatureSet feature_set);

// Segments as red as vegetation in infrared false colour are unsure.
Labels ClassifySegments(const Segments& segments,
                        const Classifier& classifier,
                        const ClassificationOptions& options);

struct TrainingSample {
  std::vector<float> features;
  bool is_grass = false;
  // When a place is left out for validation, none of its samples are used for training.
  std::string place;
};

struct TrainingOptions {
  FeatureSet feature_set = FeatureSet::kPaper18;
  // Values to choose from. The pair of depth and least samples per branch with the lowest error in
  // random folds is chosen. Paper: Sec. III-D, 10-fold, values not given.
  std::vector<int> max_depths{2, 4, 6, 8, 12, 16};
  std::vector<int> min_samples_per_branch{2, 5, 10, 20, 40};
  // Odd: every vote has a majority.
  int num_trees = 31;
  int num_folds = 10;
  int seed = 1;

  void Check() const;
};

struct TrainingReport {
  int max_depth = 0;
  int min_samples_per_branch = 0;
  // Results of cross-validation with the chosen pair.
  // - random_fold: random folds. Training and validation share places, so the error is too low.
  // - leave_one_place_out: each place is predicted from the others. NaN if there is one place only.
  double random_fold_error_ratio = 0.0;
  double random_fold_auc = 0.0;
  double leave_one_place_out_error_ratio = 0.0;
  double leave_one_place_out_auc = 0.0;
};

// The same samples, options and seed give the same result.
std::pair<Classifier, TrainingReport> TrainClassifier(const std::vector<TrainingSample>& samples,
                                                      const std::string& provenance,
                                                      const TrainingOptions& options);

struct PerceptronOptions {
  // Numbers of hidden neurons to choose from, by random folds. Paper: three layers, no numbers.
  std::vector<int> nums_hidden{4, 8, 16};
  int max_num_iterations = 200;
  int num_folds = 10;
  int seed = 1;

  void Check() const;
};

struct PerceptronReport {
  int num_hidden = 0;
  // As in TrainingReport.
  double random_fold_error_ratio = 0.0;
  double random_fold_auc = 0.0;
  double leave_one_place_out_error_ratio = 0.0;
  double leave_one_place_out_auc = 0.0;
};

// The paper's comparison, Sec. IV-A: a perceptron of three layers (OpenCV ml::ANN_MLP) on the same
// samples and folds. It is only validated: no stage uses it.
PerceptronReport ValidatePerceptron(const std::vector<TrainingSample>& samples,
                                    const PerceptronOptions& options);

}  // namespace freelsd
