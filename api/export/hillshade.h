// Private to export/. Shading of pictures of the elevation.
#pragma once

#include <opencv2/core.hpp>

#include "api/export/color_ramp.h"

namespace freelsd {

// Brightness 0..1 of a cell lit from the north-west, 45 degrees above the horizon; flat: 0.7.
// An unknown neighbour counts as level with the cell.
double Hillshade(const cv::Mat1f& elevation, int row, int col, double cell_size_m);
// The colour at that brightness. Flat ground keeps its colour.
Color Shade(const Color& color, double brightness);

}  // namespace freelsd
