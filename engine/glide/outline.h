// Private to glide/: the outlines of areas of cells.
#pragma once

#include <vector>

#include "engine/glide/reach.h"

namespace freelsd {

// Areas of cells that are not 0, largest first, within these cells: an outline cuts across corners
// inwards, never outwards, by at most 1.5 cells. Cells that touch at a corner alone are not
// connected. Areas of a few cells are left out.
std::vector<ReachArea> OutlinesOf(cv::Mat1b cells, const Grid& grid);

}  // namespace freelsd
