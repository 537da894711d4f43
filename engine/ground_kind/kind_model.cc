#include "engine/ground_kind/kind_model.h"

#include <cmath>
#include <stdexcept>
#include <utility>

#include <opencv2/dnn.hpp>

namespace freelsd {
namespace {

constexpr std::array<const char*, kNumGroundKinds> kNames{
    "grass", "rough", "crop", "stubble", "soil", "sand", "tree", "water", "sealed", "snow"};

double NumberIn(const cv::FileNode& node, const char* name, double min, double max) {
  const cv::FileNode value = node[name];
  const double number = value.isInt() || value.isReal() ? static_cast<double>(value) : NAN;
  if (number >= min && number <= max) return number;
  throw std::invalid_argument(std::string("ground kinds: ") + name + " is missing or out of range");
}

void ReadKinds(const cv::FileNode& kinds) {
  bool is_known = kinds.size() == kNames.size();
  for (size_t i = 0; is_known && i < kNames.size(); ++i) {
    is_known = static_cast<std::string>(kinds[static_cast<int>(i)]) == kNames[i];
  }
  if (!is_known) throw std::invalid_argument("ground kinds: other kinds than these ten");
}

void ReadInput(const cv::FileNode& input, KindModel::Content& content) {
  content.offset = NumberIn(input, "offset", 0.0, 255.0);
  content.scale = NumberIn(input, "scale", 1e-3, 1e3);
  content.multiple_of_px = static_cast<int>(NumberIn(input, "multiple_of_px", 1, 256));
  content.border_px = static_cast<int>(NumberIn(input, "border_px", 0, 256));
  content.dark_luma = NumberIn(input, "dark_luma", 0.0, 255.0);
  content.brightened_luma = NumberIn(input, "brightened_luma", 0.0, 255.0);
  content.largest_gain = NumberIn(input, "largest_gain", 1.0, 100.0);
}

void ReadColours(const cv::FileNode& colours, KindModel::Content& content) {
  const cv::FileNode mean = colours["mean"], inverse = colours["inverse_covariance"];
  if (mean.size() != kNumColourStatistics || inverse.size() != kNumColourStatistics) {
    throw std::invalid_argument("ground kinds: five colour statistics are needed");
  }
  for (int i = 0; i < kNumColourStatistics; ++i) {
    content.mean_colours[i] = static_cast<double>(mean[i]);
    for (int j = 0; j < kNumColourStatistics; ++j) {
      content.inverse_covariance(i, j) = static_cast<double>(inverse[i][j]);
    }
  }
  content.largest_distance = NumberIn(colours, "largest_distance", 0.0, 1e6);
}

void ReadCalibration(const cv::FileNode& calibration, KindModel::Content& content) {
  content.platt_scale = NumberIn(calibration, "platt_scale", 0.0, 100.0);
  content.platt_shift = NumberIn(calibration, "platt_shift", -100.0, 100.0);
  content.largest_probability = NumberIn(calibration, "largest_probability", 0.5, 1.0);
}

}  // namespace

const char* NameOf(GroundKind kind) { return kNames[static_cast<size_t>(kind)]; }

KindModel KindModel::Parse(const std::string& onnx, const std::string& card) {
  auto content = std::make_shared<Content>();
  content->onnx = onnx;
  try {
    const cv::FileStorage file(
        card, cv::FileStorage::READ | cv::FileStorage::MEMORY | cv::FileStorage::FORMAT_JSON);
    const cv::FileNode root = file.root();
    ReadKinds(root["kinds"]);
    content->metres_per_pixel = NumberIn(root, "metres_per_pixel", 0.01, 10.0);
    content->stride_px = static_cast<int>(NumberIn(root, "stride_px", 1, 64));
    ReadInput(root["input"], *content);
    ReadColours(root["colours"], *content);
    ReadCalibration(root["calibration"], *content);
    cv::dnn::readNetFromONNX(onnx.data(), onnx.size());
  } catch (const cv::Exception& error) {
    throw std::invalid_argument("ground kinds: " + error.err);
  }
  return KindModel(std::move(content));
}

}  // namespace freelsd
