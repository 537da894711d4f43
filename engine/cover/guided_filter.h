// Private to cover/. The guided image filter (He, Sun, Tang: Guided image filtering, TPAMI 2013),
// with colour as the guide.
#pragma once

#include "engine/cover/cover.h"

namespace freelsd {

// Averages values over the map where the photograph is even, and keeps their steps where it has
// one: in each square the values are a linear function of the colour, whose weights are pulled to 0
// by contrasts below `least_contrast` (share of full brightness). `values` has one value per cell
// of the map, NaN where unknown; it stays as it is there and where the photograph does not show the
// cell. Squares have a side of 2 radius_m.
cv::Mat1f SmoothedByPhoto(const cv::Mat1f& values,
                          const Orthophoto& photo,
                          double cell_size_m,
                          double radius_m,
                          double least_contrast);

}  // namespace freelsd
