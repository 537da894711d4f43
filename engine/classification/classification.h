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
  // The default, because it generalises best to other places. Grass is green, and its brightness
  // hardly varies at the scales of a leaf and of a bush. The forest uses four features. In the last
  // three, d is the mean log brightness over a small window minus that over a large window.
  // 1. Mean excess green, (2G - R - B) / (R + G + B).
  // 2. Logarithm of the standard deviation of d, for windows of 0.6 and 1.8 m.
  // 3. Logarithm of the standard deviation of d, for windows of 1.8 and 4.2 m.
  // 4. Skewness of d, for windows of 0.3 and 0.9 m. Fern has dark gaps between bright leaves.
  // Two more features only detect regions unlike the training grass: the mean logarithms of red /
  // green and of blue / green.
  kRobust,
};

struct ClassificationOptions {
  // --- Behaviour ---
  // A region is grass if its probability is at least min_grass_probability. It is not grass if its
  // probability is at most max_not_grass_probability. Between them it is unsure, and an unsure
  // region counts as not grass. Differs: the paper takes the majority of trees.
  double min_grass_probability = 0.7;
  double max_not_grass_probability = 0.4;
  // Regions with a mean grey level outside this range are unsure.
  double min_mean_grey = 20.0;
  double max_mean_grey = 245.0;

  void Check() const;
};

enum class Surface { kGrass, kNotGrass, kUnsure };

struct Label {
  // Probability of grass, 0..1: calibrated, or the share of votes of a model in the published form.
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

// "rgb", "hsv", "rgbhsv", "paper18", "robust", as in models and on the command line.
std::string NameOf(FeatureSet feature_set);
std::optional<FeatureSet> FeatureSetNamed(const std::string& name);

// The image that features are measured in. For kRobust, the veil of air is taken off: each channel
// less the level of its darkest pixels (dark-object subtraction, Chavez 1988), because air adds
// nearly the same light everywhere. A photograph without shadows stays as it is. Needs the whole
// photograph, BGR. Other feature sets take it unchanged.
cv::Mat3b ImageForFeatures(const cv::Mat3b& photograph, FeatureSet feature_set);

// Features of one region: only pixels where mask != 0. `image` is a part of ImageForFeatures.
std::vector<float> RegionFeatures(const cv::Mat3b& image,
                                  const cv::Mat1b& mask,
                                  double ground_sampling_distance_m,
                                  FeatureSet feature_set);

Labels ClassifySegments(const Segments& segments,
                        const Classifier& classifier,
                        const ClassificationOptions& options);

struct TrainingSample {
  std::vector<float> features;
  bool is_grass = false;
  // When a place is left out for validation, none of its samples are used for training.
  std::string place;
  // A varied copy of another sample: trained on, never validated on.
  bool is_augmented = false;
};

enum class TrainingForm {
  kCalibrated,  // settings by leaving one place out; votes calibrated; ranges of features checked
  kPublished,   // as in the paper: settings by random folds; the majority of trees decides
};

struct TrainingOptions {
  TrainingForm form = TrainingForm::kCalibrated;
  FeatureSet feature_set = FeatureSet::kRobust;
  // Values to choose from. kCalibrated leaves out one place at a time. The pair of depth and
  // least samples per branch with the lowest error is chosen. Paper: Sec. III-D, 10-fold, values
  // not given; kPublished. Differs: with random folds, training and validation share places, which
  // favours deep trees.
  std::vector<int> max_depths{4, 6};
  std::vector<int> min_samples_per_branch{20, 60};
  int num_trees = 30;
  int num_folds = 10;
  int seed = 1;

  void Check() const;
};

struct TrainingReport {
  int max_depth = 0;
  int min_samples_per_branch = 0;
  // Results of cross-validation with the chosen pair. They rate the forest's majority vote, before
  // calibration and range check. Augmented samples are not rated.
  // - random_fold: random folds.
  // - leave_one_place_out: each place is predicted from the others. If there is only one place,
  //   random folds are used.
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
