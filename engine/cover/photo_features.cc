#include "engine/cover/photo_features.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// Avoids a division by zero: the mean is 0 where nothing is seen.
constexpr double kNoWeight = 1e-6;

}  // namespace

ColorPlanes BlurredColors(const cv::Mat3b& image, const cv::Mat1f& share, double blur_px) {
  ColorPlanes colors;
  for (cv::Mat1f& plane : colors) plane = cv::Mat1f::zeros(image.size());
  for (int row = 0; row < image.rows; ++row) {
    for (int col = 0; col < image.cols; ++col) {
      const float weight = share(row, col);
      if (weight <= 0.0f) continue;
      const cv::Vec3f color = cv::Vec3f(image(row, col)) / weight;
      const float sum = color[0] + color[1] + color[2] + 3.0f;
      colors[0](row, col) = weight * (2.0f * color[1] - color[0] - color[2]) / sum;
      colors[1](row, col) = weight * (color[2] - color[0]) / sum;
      colors[2](row, col) = weight * std::log(sum);
    }
  }
  cv::Mat1f weight;
  cv::GaussianBlur(share, weight, {}, blur_px);
  for (cv::Mat1f& plane : colors) {
    cv::GaussianBlur(plane, plane, {}, blur_px);
    plane = plane / (weight + kNoWeight);
  }
  return colors;
}

cv::Mat1b WithoutSpecks(const cv::Mat1b& mask, double min_num_cells) {
  cv::Mat1i labels;
  cv::Mat stats, centers;
  const int num_labels = cv::connectedComponentsWithStats(mask, labels, stats, centers);
  std::vector<uint8_t> kept(static_cast<size_t>(num_labels), 0);
  for (int label = 1; label < num_labels; ++label) {
    if (stats.at<int>(label, cv::CC_STAT_AREA) >= min_num_cells) {
      kept[static_cast<size_t>(label)] = 255;
    }
  }
  cv::Mat1b result(mask.size());
  std::transform(labels.begin(), labels.end(), result.begin(), [&](int label) {
    return kept[static_cast<size_t>(label)];
  });
  return result;
}

}  // namespace freelsd
