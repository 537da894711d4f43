#include "engine/geometry/box_mean.h"

#include <opencv2/imgproc.hpp>

namespace freelsd {

int BoxSide(double width_cells) { return 2 * static_cast<int>(0.5 * width_cells) + 1; }

cv::Mat1f BoxMean(const cv::Mat1f& values, int side, BoxBorder border) {
  const int border_type =
      border == BoxBorder::kMirrored ? cv::BORDER_REFLECT_101 : cv::BORDER_CONSTANT;
  cv::Mat1f mean;
  cv::boxFilter(values, mean, CV_32F, {side, side}, {-1, -1}, true, border_type);
  return mean;
}

cv::Mat1d BoxSum(const cv::Mat1d& values, int side) {
  cv::Mat1d sum;
  cv::boxFilter(values, sum, CV_64F, {side, side}, {-1, -1}, false, cv::BORDER_CONSTANT);
  return sum;
}

}  // namespace freelsd
