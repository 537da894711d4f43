// Private to hazard/. Distances to cells that are not free.
#pragma once

#include "engine/hazard/hazard.h"

namespace freelsd {

// Metres from each cell's centre to the nearest centre of a cell whose value is not kFree. Cells
// just outside the grid count as unseen.
cv::Mat1f DistanceToHazard(const cv::Mat1b& hazard, double cell_size_m);

}  // namespace freelsd
