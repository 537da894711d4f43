// Private to cover/. Finds fences in meadows. Neither heights nor patches of colour reveal a fence;
// in the orthophoto its posts and the grass below it form a thin dark line.
#pragma once

#include "engine/cover/cover.h"

namespace freelsd {

// Cells of `grid` that such a line crosses: 255, else 0. `is_meadow`: the cells of `grid` to
// search.
cv::Mat1b FindFences(const Orthophoto& photo,
                     const cv::Mat1b& is_meadow,
                     const Grid& grid,
                     const CoverOptions& options);

}  // namespace freelsd
