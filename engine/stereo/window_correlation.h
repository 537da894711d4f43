// Private to stereo/. Compares windows of two 8-bit images.
#pragma once

#include <opencv2/core.hpp>

namespace freelsd {

struct CorrelationOptions {
  // Odd.
  int window_px = 15;
  // Least variance of the grey levels of each window; not negative.
  double min_variance = 0.0;
  // Least normalised cross-correlation.
  double min_correlation = 0.0;
};

// 255 where the windows around a pixel exceed min_variance and min_correlation, else 0. Images are
// mirrored at their borders.
cv::Mat1b AlikeWindows(const cv::Mat1b& a, const cv::Mat1b& b, const CorrelationOptions& options);

}  // namespace freelsd
