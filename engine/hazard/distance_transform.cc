#include "engine/hazard/distance_transform.h"

#include <opencv2/imgproc.hpp>

namespace freelsd {

cv::Mat1f DistanceToHazard(const cv::Mat1b& hazard, double cell_size_m) {
  if (hazard.empty()) return {};
  cv::Mat1b is_free;
  cv::copyMakeBorder(hazard == kFree, is_free, 1, 1, 1, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  cv::Mat1f cells, metres;
  cv::distanceTransform(is_free, cells, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cells(cv::Rect(1, 1, hazard.cols, hazard.rows)).convertTo(metres, CV_32F, cell_size_m);
  return metres;
}

}  // namespace freelsd
