#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "engine/check/check.h"
#include "engine/classification/classification.h"
#include "engine/classification/features.h"
#include "engine/classification/model.h"

namespace freelsd {
namespace {

constexpr int kModelVersion = 1;
// Value of `form` in a model without calibration and ranges.
constexpr const char* kPublishedForm = "published";
// Soil and leaf litter rarely reach this; vegetation in infrared false colour has 1.4 to 2.
constexpr double kMaxRedToGreen = 1.35;
// Upper limit outside the training range: midway between grass and not grass.
constexpr double kUnsureProbability = 0.5;

bool IsInGrassRange(const Classifier::Model& model, const std::vector<float>& features) {
  for (size_t i = 0; i < features.size(); ++i) {
    const RangeMargin margin = MarginOf(model.feature_set, i);
    const float range = model.grass_max[i] - model.grass_min[i];
    if (features[i] < std::max(margin.least, model.grass_min[i] - margin.below * range) ||
        features[i] > model.grass_max[i] + margin.above * range) {
      return false;
    }
  }
  return true;
}

// Whether nodes, in preorder, form one complete tree. OpenCV does not check them and aborts the
// process on a truncated file.
bool IsWholeTree(const cv::FileNode& nodes, int num_variables, int num_classes) {
  const auto is_index = [](int index, int count) { return index >= 0 && index < count; };
  std::vector<int> awaited_depths{0};
  for (const cv::FileNode& node : nodes) {
    if (awaited_depths.empty() || static_cast<int>(node["depth"]) != awaited_depths.back() ||
        !is_index(static_cast<int>(node["norm_class_idx"]), num_classes)) {
      return false;
    }
    const int child_depth = awaited_depths.back() + 1;
    awaited_depths.pop_back();
    for (const cv::FileNode& split : node["splits"]) {
      if (!is_index(static_cast<int>(split["var"]), num_variables)) return false;
    }
    if (node["splits"].size() > 0) awaited_depths.insert(awaited_depths.end(), 2, child_depth);
  }
  return awaited_depths.empty();
}

void CheckForest(const cv::FileNode& forest) {
  const cv::FileNode trees = forest["trees"];
  const int num_variables = static_cast<int>(forest["var_count"]);
  const int num_classes = static_cast<int>(forest["class_labels"].size());
  bool is_whole =
      trees.size() > 0 && static_cast<size_t>(static_cast<int>(forest["ntrees"])) == trees.size();
  for (const cv::FileNode& tree : trees) {
    is_whole = is_whole && IsWholeTree(tree["nodes"], num_variables, num_classes);
  }
  if (!is_whole) throw std::invalid_argument("grass model: the forest is cut or damaged");
}

void CheckModel(const Classifier::Model& model) {
  // A calibrated model without ranges is cut.
  const size_t num_features = model.calibration ? NumFeatures(model.feature_set) : 0;
  if (model.grass_min.size() != num_features || model.grass_max.size() != num_features) {
    throw std::invalid_argument("grass model: ranges do not fit the feature set");
  }
  if (!model.forest || !model.forest->isTrained() ||
      model.forest->getVarCount() != static_cast<int>(NumForestFeatures(model.feature_set))) {
    throw std::invalid_argument("grass model: the forest does not fit the feature set");
  }
}

std::shared_ptr<Classifier::Model> ReadModel(const cv::FileStorage& file) {
  if (static_cast<int>(file["version"]) != kModelVersion) {
    throw std::invalid_argument("grass model: version must be " + std::to_string(kModelVersion));
  }
  auto model = std::make_shared<Classifier::Model>();
  const std::optional<FeatureSet> feature_set =
      FeatureSetNamed(static_cast<std::string>(file["feature_set"]));
  if (!feature_set) throw std::invalid_argument("grass model: unknown feature set");
  model->feature_set = *feature_set;
  model->provenance = static_cast<std::string>(file["provenance"]);
  if (static_cast<std::string>(file["form"]) != kPublishedForm) {
    model->calibration = Calibration{static_cast<double>(file["calibration_slope"]),
                                     static_cast<double>(file["calibration_offset"])};
    file["grass_min"] >> model->grass_min;
    file["grass_max"] >> model->grass_max;
  }
  CheckForest(file["forest"]);
  model->forest = cv::ml::RTrees::create();
  model->forest->read(file["forest"]);
  CheckModel(*model);
  return model;
}

// Neither too dark, nor burnt out, nor as red as vegetation in infrared.
bool CanBeTold(const cv::Scalar& mean_bgr, const ClassificationOptions& options) {
  const double grey = (mean_bgr[0] + mean_bgr[1] + mean_bgr[2]) / 3.0;
  return grey >= options.min_mean_grey && grey <= options.max_mean_grey &&
         mean_bgr[2] <= kMaxRedToGreen * mean_bgr[1];
}

// Labels resampled to the size of the detail image.
cv::Mat1i LabelsInDetail(const Segments& segments) {
  cv::Mat1i labels;
  cv::resize(segments.labels, labels, segments.detail_image.size(), 0.0, 0.0, cv::INTER_NEAREST);
  return labels;
}

// Bounding box of every label, by label. Scans rows run by run.
std::vector<cv::Rect> BoxesOf(const cv::Mat1i& labels, size_t num_labels) {
  std::vector<cv::Rect> boxes(num_labels + 1);
  for (int y = 0; y < labels.rows; ++y) {
    const int* row = labels[y];
    for (int x = 0; x < labels.cols;) {
      const int label = row[x], first = x;
      while (x < labels.cols && row[x] == label) ++x;
      if (label > 0) boxes[static_cast<size_t>(label)] |= cv::Rect(first, y, x - first, 1);
    }
  }
  return boxes;
}

}  // namespace

Surface SurfaceOf(double probability, const ClassificationOptions& options) {
  if (probability >= options.min_grass_probability) return Surface::kGrass;
  if (probability <= options.max_not_grass_probability) return Surface::kNotGrass;
  return Surface::kUnsure;
}

void ClassificationOptions::Check() const {
  const FieldCheck check("classification");
  check.Inside("min_grass_probability", min_grass_probability, 0.5, 1.0);
  check.Require(
      max_not_grass_probability >= 0.0 && max_not_grass_probability < min_grass_probability,
      "max_not_grass_probability",
      max_not_grass_probability,
      "must be >= 0 and below min_grass_probability");
  check.Require(min_mean_grey >= 0.0 && min_mean_grey < max_mean_grey,
                "min_mean_grey",
                min_mean_grey,
                "must be >= 0 and below max_mean_grey");
  check.Require(max_mean_grey <= 255.0, "max_mean_grey", max_mean_grey, "must be <= 255");
}

Classifier::Classifier(std::shared_ptr<const Model> model) : model_(std::move(model)) {}

Classifier Classifier::Parse(const std::string& model_text) {
  try {
    const cv::FileStorage file(model_text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
    return Classifier(ReadModel(file));
  } catch (const cv::Exception& error) {
    throw std::invalid_argument("grass model: " + error.err);
  } catch (const std::length_error&) {
    throw std::invalid_argument("grass model: OpenCV cannot read it");
  }
}

std::string Classifier::Serialize() const {
  cv::FileStorage file(".yml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
  file << "version" << kModelVersion << "feature_set" << NameOf(model_->feature_set);
  file << "provenance" << model_->provenance;
  if (model_->calibration) {
    file << "calibration_slope" << model_->calibration->slope;
    file << "calibration_offset" << model_->calibration->offset;
    file << "grass_min" << model_->grass_min << "grass_max" << model_->grass_max;
  } else {
    file << "form" << kPublishedForm;
  }
  file << "forest"
       << "{";
  model_->forest->write(file);
  file << "}";
  return file.releaseAndGetString();
}

FeatureSet Classifier::feature_set() const { return model_->feature_set; }

const std::string& Classifier::provenance() const { return model_->provenance; }

double Classifier::Predict(const std::vector<float>& features) const {
  if (features.size() != NumFeatures(model_->feature_set)) {
    throw std::invalid_argument("classification: " + std::to_string(features.size()) +
                                " features, the model has " +
                                std::to_string(NumFeatures(model_->feature_set)));
  }
  const double votes = GrassVotes(*model_->forest, features);
  if (!model_->calibration) return votes;
  const auto& [slope, offset] = *model_->calibration;
  const double probability = 1.0 / (1.0 + std::exp(-(slope * votes + offset)));
  if (IsInGrassRange(*model_, features)) return probability;
  return std::min(probability, kUnsureProbability);
}

double GrassVotes(const cv::ml::RTrees& forest, const std::vector<float>& features) {
  const cv::Mat1f row(1, forest.getVarCount(), const_cast<float*>(features.data()));
  cv::Mat1i votes;
  forest.getVotes(row, votes, 0);
  // First row: class labels; second: votes for each.
  double grass = 0.0, all = 0.0;
  for (int col = 0; col < votes.cols; ++col) {
    all += votes(1, col);
    if (votes(0, col) == 1) grass = votes(1, col);
  }
  return all > 0.0 ? grass / all : 0.0;
}

Labels ClassifySegments(const Segments& segments,
                        const Classifier& classifier,
                        const ClassificationOptions& options) {
  const cv::Mat1i regions = LabelsInDetail(segments);
  const std::vector<cv::Rect> boxes = BoxesOf(regions, segments.segments.size());
  const cv::Rect frame({0, 0}, regions.size());
  // Filters need some surroundings of the region.
  constexpr int kSurroundingsPx = 16;
  const cv::Mat3b clear = ImageForFeatures(segments.detail_image, classifier.feature_set());
  Labels labels;
  for (const Segment& segment : segments.segments) {
    cv::Rect box = boxes[static_cast<size_t>(segment.label)];
    box = cv::Rect(box.x - kSurroundingsPx,
                   box.y - kSurroundingsPx,
                   box.width + 2 * kSurroundingsPx,
                   box.height + 2 * kSurroundingsPx) &
          frame;
    const cv::Mat1b mask = regions(box) == segment.label;
    Label label;
    if (CanBeTold(cv::mean(segments.detail_image(box), mask), options)) {
      label.probability = classifier.Predict(RegionFeatures(
          clear(box), mask, segments.detail_sampling_distance_m, classifier.feature_set()));
      label.surface = SurfaceOf(label.probability, options);
    }
    labels.push_back(label);
  }
  return labels;
}

}  // namespace freelsd
