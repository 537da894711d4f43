// Private to stereo/. Disparities of a rectified pair: costs of Birchfield and Tomasi (1998) over
// blocks, summed along three paths (Hirschmueller 2008). cv::StereoSGBM in MODE_SGBM_3WAY uses the
// same method. This code is twice as fast on one core and equally good (freelsd-bench --filter
// kernel_semi_global), and it does not depend on OpenCV's version.
#pragma once

#include <opencv2/core.hpp>

namespace freelsd {

// Disparities are counted in sixteenths of a pixel.
constexpr int kDisparityUnit = 16;

struct SemiGlobalOptions {
  int min_disparity_px = 0;
  // A multiple of 16, at most 1024.
  int num_disparities = 16;
  int block_size_px = 7;
  // p1: penalty if the disparity differs by one from that of the previous pixel. p2: penalty if it
  // differs by more. A penalty above the largest block cost is reduced to the largest block cost.
  int p1 = 1;
  int p2 = 2;
  int max_left_right_difference_px = 1;
  int uniqueness_ratio_percent = 0;
  int speckle_size_px = 0;
  int speckle_range_px = 2;
};

// Left column minus right column, in sixteenths of a pixel. (min_disparity_px - 1) * 16 where there
// is no match. The result does not depend on the number of threads.
cv::Mat1s MatchSemiGlobally(const cv::Mat1b& left,
                            const cv::Mat1b& right,
                            const SemiGlobalOptions& options);

}  // namespace freelsd
