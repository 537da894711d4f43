// Input: a grey image and a request. Output: corners (Shi and Tomasi 1994).
// The corners of cv::goodFeaturesToTrack, four times as fast on one core: freelsd-bench --filter
// kernel_corners.
#pragma once

#include <vector>

#include <opencv2/core.hpp>

namespace freelsd {

struct CornerWish {
  // Corners lie where it is not 0, never in the image's outermost pixels.
  cv::Mat1b mask;
  int max_count = 0;
  // Least strength, as a share of the strongest corner.
  double min_quality = 0.0;
  double min_distance_px = 0.0;
};

// Strongest first; each at least min_distance_px from all before it.
std::vector<cv::Point> StrongestCorners(const cv::Mat1b& grey, const CornerWish& wish);

}  // namespace freelsd
