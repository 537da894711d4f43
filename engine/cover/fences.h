// Private to cover/. Fences in meadows. Neither heights nor patch colour show them; in the
// orthophoto their posts and the grass below form a thin dark line.
#pragma once

#include "engine/cover/cover.h"

namespace freelsd {

// Cells of `grid` on such a line: 255, else 0. `is_meadow`: cells of `grid` that are searched.
cv::Mat1b FindFences(const Orthophoto& photo,
                     const cv::Mat1b& is_meadow,
                     const Grid& grid,
                     const CoverOptions& options);

}  // namespace freelsd
