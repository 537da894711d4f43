// Private to recorded/: outlines as cells of a grid.
#pragma once

#include "engine/terrain/terrain.h"

namespace freelsd {

// 255 in all cells that the outline encloses or touches. A thin outline never vanishes.
cv::Mat1b MaskOf(const Polygon& outline, const Grid& grid);

}  // namespace freelsd
