// Private to cover/. Features of the orthophoto that several rules use.
#pragma once

#include <array>

#include <opencv2/core.hpp>

#include "engine/cover/cover.h"

namespace freelsd {

// Greenness, red minus blue (both as shares of the brightness), log brightness.
using ColorPlanes = std::array<cv::Mat1f, 3>;

// Blurs seen pixels only. `share`: seen share of each pixel, 0..1. Unseen pixels of `image` must be
// black.
ColorPlanes BlurredColors(const cv::Mat3b& image, const cv::Mat1f& share, double blur_px);

// Removes connected patches smaller than min_num_cells.
cv::Mat1b WithoutSpecks(const cv::Mat1b& mask, double min_num_cells);

}  // namespace freelsd
