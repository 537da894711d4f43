// Private to hazard/. Exact Euclidean distance transform.
#pragma once

#include "engine/hazard/hazard.h"

namespace freelsd {

// Metres from each cell's centre to the nearest centre of a cell whose value is not kFree. A ring
// of unseen cells lies around the grid.
cv::Mat1f DistanceToHazard(const cv::Mat1b& hazard, double cell_size_m);

}  // namespace freelsd
