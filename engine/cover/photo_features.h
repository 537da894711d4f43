// Private to cover/. Features of the orthophoto that several rules use.
#pragma once

#include <array>

#include <opencv2/core.hpp>

#include "engine/cover/cover.h"

namespace freelsd {

// Greenness, red against blue, log brightness.
using ColorPlanes = std::array<cv::Mat1f, 3>;

// Least deviation of each plane: no ground is more even.
inline constexpr std::array<float, 3> kLeastColorDeviation{0.006f, 0.006f, 0.02f};

// Blurred over seen pixels only. `share`: seen share of each pixel, 0..1. Unseen pixels must be
// black in the image.
ColorPlanes BlurredColors(const cv::Mat3b& image, const cv::Mat1f& share, double blur_px);

// The orthophoto's colours in the cells of the map, through a blur of one metre.
struct ColorsOnMap {
  ColorPlanes colors;
  // 255 where at least half of the cell is seen, else 0.
  cv::Mat1b is_seen;
};

ColorsOnMap ColorsOfMap(const Orthophoto& photo, const Grid& grid);

// Without connected patches smaller than min_num_cells.
cv::Mat1b WithoutSpecks(const cv::Mat1b& mask, double min_num_cells);

}  // namespace freelsd
