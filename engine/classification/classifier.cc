#include <stdexcept>
#include <string>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "engine/check/check.h"
#include "engine/classification/classification.h"
#include "engine/classification/model.h"

namespace freelsd {
namespace {

constexpr int kModelVersion = 2;
// Soil and leaf litter rarely reach this; vegetation in infrared false colour has 1.4 to 2.
constexpr double kMaxRedToGreen = 1.35;

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
  if (!model.forest || !model.forest->isTrained() ||
      model.forest->getVarCount() != static_cast<int>(NumFeatures(model.feature_set))) {
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
  CheckForest(file["forest"]);
  model->forest = cv::ml::RTrees::create();
  model->forest->read(file["forest"]);
  CheckModel(*model);
  return model;
}

bool IsRedAsInInfrared(const cv::Scalar& mean_bgr) {
  return mean_bgr[2] > kMaxRedToGreen * mean_bgr[1];
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
  return GrassVotes(*model_->forest, features);
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
  Labels labels;
  for (const Segment& segment : segments.segments) {
    cv::Rect box = boxes[static_cast<size_t>(segment.label)];
    box = cv::Rect(box.x - kSurroundingsPx,
                   box.y - kSurroundingsPx,
                   box.width + 2 * kSurroundingsPx,
                   box.height + 2 * kSurroundingsPx) &
          frame;
    const cv::Mat1b mask = regions(box) == segment.label;
    const cv::Mat3b image = segments.detail_image(box);
    Label label;
    if (!IsRedAsInInfrared(cv::mean(image, mask))) {
      label.probability = classifier.Predict(RegionFeatures(image, mask, classifier.feature_set()));
      label.surface = SurfaceOf(label.probability, options);
    }
    labels.push_back(label);
  }
  return labels;
}

}  // namespace freelsd
