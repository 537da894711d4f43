// Private to hazard/. Fences in meadows. Neither the map of heights nor the colour of a patch tells
// of them; in the picture from above their posts, and what lies below them, are a thin dark line.
#pragma once

#include "engine/hazard/hazard.h"

namespace freelsd {

// Cells of `grid` on such a line: 255, else 0. `is_meadow`: cells of `grid` that may have any.
cv::Mat1b FindFences(const Orthophoto& photo,
                     const cv::Mat1b& is_meadow,
                     const Grid& grid,
                     const HazardOptions& options);

}  // namespace freelsd
