// Input: a grey image and a request. Output: corners (Shi and Tomasi 1994). Finds the same corners
// as cv::goodFeaturesToTrack. On one core it is four times as fast (freelsd-bench --filter
// kernel_corners).
#pragma once

#include <vector>

#include <opencv2/core.hpp>

namespace freelsd {

struct CornerWish {
  // Corners lie where the mask is not 0, but never in the image's outermost rows and columns.
  cv::Mat1b mask;
  int max_count = 0;
  // Least corner strength, as a share of that of the strongest corner.
  double min_quality = 0.0;
  double min_distance_px = 0.0;
};

// Strongest first. Two returned corners are at least min_distance_px apart.
std::vector<cv::Point> StrongestCorners(const cv::Mat1b& grey, const CornerWish& wish);

}  // namespace freelsd
