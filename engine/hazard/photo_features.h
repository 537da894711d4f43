// Private to hazard/. What several rules read from the picture from above.
#pragma once

#include <array>

#include <opencv2/core.hpp>

#include "engine/terrain/terrain.h"

namespace freelsd {

// How green, how red against blue, how bright (logarithm).
using ColorPlanes = std::array<cv::Mat1f, 3>;

// No ground is more even than that, plane by plane.
inline constexpr std::array<float, 3> kLeastColorDeviation{0.006f, 0.006f, 0.02f};

// Of the seen ground alone, through a blur. `share` of each pixel that was seen, 0..1; what was not
// is black in the image.
ColorPlanes BlurredColors(const cv::Mat3b& image, const cv::Mat1f& share, double blur_px);

// The picture's colours in the cells of the map, through a blur of a metre.
struct ColorsOnMap {
  ColorPlanes colors;
  // At least half of the cell: 255, else 0.
  cv::Mat1b is_seen;
};

ColorsOnMap ColorsOfMap(const Orthophoto& photo, const Grid& grid);

// Without connected patches smaller than that.
cv::Mat1b WithoutSpecks(const cv::Mat1b& mask, double min_num_cells);

}  // namespace freelsd
