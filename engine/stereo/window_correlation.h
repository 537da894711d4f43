// Private to stereo/. Where windows of two 8-bit images look alike.
#pragma once

#include <opencv2/core.hpp>

namespace freelsd {

struct CorrelationOptions {
  // Odd.
  int window_px = 15;
  // Of the grey levels of each window; not negative.
  double min_variance = 0.0;
  // Normalised cross-correlation.
  double min_correlation = 0.0;
};

// 255 where the windows around a pixel vary more and correlate more than that, else 0. The images
// are mirrored at their borders.
cv::Mat1b AlikeWindows(const cv::Mat1b& a, const cv::Mat1b& b, const CorrelationOptions& options);

}  // namespace freelsd
