// Private to cover/. Finds fences in meadows. Neither heights nor patches of colour reveal a fence;
// in the orthophoto its posts and the grass below it form a thin dark line.
#pragma once

#include "engine/cover/cover.h"

namespace freelsd {

// One value per cell of `grid`: 255 where a fence crosses the cell, else 0. `is_meadow`: the cells
// of `grid` that are searched.
cv::Mat1b FindFences(const Orthophoto& photo,
                     const cv::Mat1b& is_meadow,
                     const Grid& grid,
                     const CoverOptions& options);

}  // namespace freelsd
