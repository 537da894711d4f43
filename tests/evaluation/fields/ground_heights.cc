#include "tests/evaluation/fields/ground_heights.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

double MedianOf(const cv::Mat1f& raster) {
  std::vector<float> values;
  for (const float value : raster) {
    if (!std::isnan(value)) values.push_back(value);
  }
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

cv::Mat1f FilledFromNearest(const cv::Mat1f& raster) {
  cv::Mat1b is_unseen(raster.size());
  std::transform(raster.begin(), raster.end(), is_unseen.begin(), [](float height) {
    return std::isnan(height) ? uint8_t{255} : uint8_t{0};
  });
  cv::Mat1f distance;
  cv::Mat1i labels;
  cv::distanceTransform(
      is_unseen, distance, labels, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  std::map<int, float> values;
  for (int row = 0; row < raster.rows; ++row) {
    for (int col = 0; col < raster.cols; ++col) {
      if (is_unseen(row, col) == 0) values[labels(row, col)] = raster(row, col);
    }
  }
  cv::Mat1f filled(raster.size(), 0.0f);
  if (values.empty()) return filled;
  for (int row = 0; row < raster.rows; ++row) {
    for (int col = 0; col < raster.cols; ++col) filled(row, col) = values.at(labels(row, col));
  }
  return filled;
}

}  // namespace

GroundHeights::GroundHeights(const Grid& grid, const cv::Mat1f& heights)
    : grid_(grid), median_(MedianOf(heights)) {
  if (!heights.empty()) filled_ = FilledFromNearest(heights);
}

double GroundHeights::At(const Eigen::Vector2d& place_in_world) const {
  if (filled_.empty()) return median_;
  const Eigen::Vector2d cells = (place_in_world - grid_.north_west_in_world) / grid_.cell_size_m;
  const double col = std::clamp(cells.x() - 0.5, 0.0, filled_.cols - 1.0);
  const double row = std::clamp(-cells.y() - 0.5, 0.0, filled_.rows - 1.0);
  const int left = static_cast<int>(col), top = static_cast<int>(row);
  const int right = std::min(left + 1, filled_.cols - 1);
  const int bottom = std::min(top + 1, filled_.rows - 1);
  const double u = col - left, v = row - top;
  return (1.0 - v) * ((1.0 - u) * filled_(top, left) + u * filled_(top, right)) +
         v * ((1.0 - u) * filled_(bottom, left) + u * filled_(bottom, right));
}

}  // namespace freelsd
