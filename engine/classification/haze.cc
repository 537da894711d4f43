#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <opencv2/imgproc.hpp>

#include "engine/classification/classification.h"

namespace freelsd {
namespace {

// Share of the pixels that are shadow in nearly every photograph.
constexpr double kDarkRatio = 0.005;
// Shadows are not black: a part of their light comes from the ground.
constexpr double kVeilRatio = 0.9;
// No photograph worth classifying has a thicker veil, grey levels.
constexpr double kMaxVeilGrey = 60.0;
// The darkest pixels are lit ground, not shadows, if their grey level is above kLitRatio of the
// median. Recorded photographs lie below 0.72, even surfaces without shadows above 0.85. Between
// the two bounds a part of the veil is taken off.
constexpr double kShadowRatio = 0.75;
constexpr double kLitRatio = 0.85;
// Darker pixels, summed over the channels, were not recorded: borders of a rectified image.
constexpr int kLeastRecordedSum = 6;

using Histogram = std::array<int64_t, 256>;

std::array<Histogram, 3> HistogramsOf(const cv::Mat3b& image) {
  std::array<Histogram, 3> histograms{};
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const cv::Vec3b& bgr = image(y, x);
      if (bgr[0] + bgr[1] + bgr[2] < kLeastRecordedSum) continue;
      for (int channel = 0; channel < 3; ++channel) {
        ++histograms[static_cast<size_t>(channel)][bgr[channel]];
      }
    }
  }
  return histograms;
}

// The lowest level with more than this share of the pixels at or below it.
int LevelAt(const Histogram& histogram, double ratio) {
  int64_t num_pixels = 0;
  for (const int64_t count : histogram) num_pixels += count;
  int64_t below = 0;
  int level = 0;
  for (; level < 255; ++level) {
    below += histogram[static_cast<size_t>(level)];
    if (static_cast<double>(below) > ratio * static_cast<double>(num_pixels)) break;
  }
  return level;
}

// 1 if the darkest pixels are shadows, 0 if they are lit ground.
double ShadowShare(const std::array<Histogram, 3>& histograms) {
  double dark = 0.0, median = 0.0;
  for (const Histogram& histogram : histograms) {
    dark += LevelAt(histogram, kDarkRatio);
    median += LevelAt(histogram, 0.5);
  }
  const double ratio = dark / std::max(1.0, median);
  return std::clamp((kLitRatio - ratio) / (kLitRatio - kShadowRatio), 0.0, 1.0);
}

double VeilOf(const Histogram& histogram) {
  return std::min(kMaxVeilGrey, kVeilRatio * LevelAt(histogram, kDarkRatio));
}

}  // namespace

cv::Mat3b ImageForFeatures(const cv::Mat3b& photograph, FeatureSet feature_set) {
  if (feature_set != FeatureSet::kRobust) return photograph;
  const std::array<Histogram, 3> histograms = HistogramsOf(photograph);
  const double share = ShadowShare(histograms);
  cv::Scalar veil;
  for (int channel = 0; channel < 3; ++channel) {
    veil[channel] = std::floor(share * VeilOf(histograms[static_cast<size_t>(channel)]));
  }
  cv::Mat3b clear;
  cv::subtract(photograph, veil, clear);
  return clear;
}

}  // namespace freelsd
