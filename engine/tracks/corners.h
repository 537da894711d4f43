// Input: a grey image and where corners are wanted. Output: corners (Shi and Tomasi 1994).
#pragma once

#include <vector>

#include <opencv2/core.hpp>

namespace freelsd {

struct CornerWish {
  // Corners are sought where it is not 0; never in the image's outermost pixels.
  cv::Mat1b mask;
  int max_count = 0;
  // Least strength, share of the strongest.
  double min_quality = 0.0;
  double min_distance_px = 0.0;
};

// The strongest first, each at least min_distance_px from those before it.
std::vector<cv::Point> StrongestCorners(const cv::Mat1b& grey, const CornerWish& wish);

}  // namespace freelsd
