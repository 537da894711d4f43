// Private to stereo/. Disparities of a rectified pair, the same as OpenCV's but sooner.
#pragma once

#include <opencv2/core.hpp>

namespace freelsd {

// OpenCV's matcher gives disparities in sixteenths of a pixel.
constexpr int kDisparityUnit = 16;

struct SemiGlobalOptions {
  int min_disparity_px = 0;
  // A multiple of 16.
  int num_disparities = 16;
  int block_size_px = 7;
  int p1 = 1;
  int p2 = 2;
  int max_left_right_difference_px = 1;
  int uniqueness_ratio_percent = 0;
  int speckle_size_px = 0;
  int speckle_range_px = 2;
};

// Left column minus right column in sixteenths of a pixel; (min_disparity_px - 1) * 16 where
// nothing matches. That of cv::StereoSGBM in MODE_SGBM_3WAY of OpenCV 4.6, byte for byte.
cv::Mat1s MatchSemiGlobally(const cv::Mat1b& left,
                            const cv::Mat1b& right,
                            const SemiGlobalOptions& options);

}  // namespace freelsd
