// Input: a photograph and its ground sampling distance. Output: the kind of ground at each place.
// Source: a network of our own; training/README.md is its model card.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <variant>

#include <opencv2/core.hpp>

#include "engine/classification/classification.h"

namespace freelsd {

// In the order of the network's output. kGrass: fit to land on. kSealed: paved, built, an object.
enum class GroundKind : uint8_t {
  kGrass,
  kRough,
  kCrop,
  kStubble,
  kSoil,
  kSand,
  kTree,
  kWater,
  kSealed,
  kSnow,
};
constexpr int kNumGroundKinds = 10;
// "grass", "rough", "crop", "stubble", "soil", "sand", "tree", "water", "sealed", "snow".
const char* NameOf(GroundKind kind);

// The network, and what its training measured. Immutable, shared by its copies.
class KindModel {
 public:
  // `onnx`: content of ground_kind.onnx; `card`: of ground_kind.json. Throws std::invalid_argument
  // if they are no model.
  static KindModel Parse(const std::string& onnx, const std::string& card);

  struct Content;
  const Content& content() const { return *content_; }

 private:
  explicit KindModel(std::shared_ptr<const Content> content) : content_(std::move(content)) {}

  std::shared_ptr<const Content> content_;
};

// What one photograph says. Both rasters have one value for a square of the photograph.
struct KindPicture {
  // 0 = not told, else 1 + round(254 * probability of grass), calibrated.
  cv::Mat1b grass;
  // The likeliest of the other kinds and its probability (LikelyKind); empty if only grass is told.
  cv::Mat1b other;
  double image_px_per_px = 1.0;
};

// A kind in the upper half of a byte, its probability in steps of 1/15, rounded down, in the lower.
struct LikelyKind {
  GroundKind kind = GroundKind::kRough;
  float probability = 0.0f;

  uint8_t Packed() const;
  static LikelyKind Unpack(uint8_t packed);
};

// Runs the network. The result has the same bytes on any number of threads. Not thread-safe; a
// network each.
class KindNetwork {
 public:
  explicit KindNetwork(const KindModel& model);
  ~KindNetwork();
  KindNetwork(KindNetwork&&) noexcept;
  KindNetwork& operator=(KindNetwork&&) noexcept;

  // Everything is not told if the colours of the photograph lie outside those of the training, if
  // it is too coarse, or if it shows too much ground at once (70 ha).
  // `photograph`: BGR or grey, 8 bit.
  KindPicture Tell(const cv::Mat& photograph, double ground_sampling_distance_m);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// What tells grass: the network, or the forest of Preset::kPaper.
using GroundModel = std::variant<KindModel, Classifier>;

// A model and the bytes of its files.
struct GroundModelFile {
  GroundModel model;
  std::string bytes;
};
// An ONNX file with its card beside it (same name, .json), or a forest in another file. Throws
// std::invalid_argument if a file cannot be read or is no model.
GroundModelFile ReadGroundModel(const std::filesystem::path& file);

// The labels of segments: the mean probability over each. A segment is unsure where most of it is
// not told.
Labels LabelsOf(const Segments& segments,
                const KindPicture& picture,
                const ClassificationOptions& options);

// The same picture as ClassifySegments tells it: each segment has one probability.
KindPicture PictureOf(const Segments& segments, const Labels& labels);

}  // namespace freelsd
