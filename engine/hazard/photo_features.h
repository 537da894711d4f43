// Private to hazard/. What several rules read from the picture from above.
#pragma once

#include <array>

#include <opencv2/core.hpp>

namespace freelsd {

// How green, how red against blue, how bright (logarithm).
using ColorPlanes = std::array<cv::Mat1f, 3>;

// Of the seen ground alone, through a blur. `share` of each pixel that was seen, 0..1; what was not
// is black in the image.
ColorPlanes BlurredColors(const cv::Mat3b& image, const cv::Mat1f& share, double blur_px);

// Without connected patches smaller than that.
cv::Mat1b WithoutSpecks(const cv::Mat1b& mask, double min_num_cells);

}  // namespace freelsd
