// Private to cover/. Closed crops: even, and above the ground.
#pragma once

#include "engine/cover/cover.h"

namespace freelsd {

// Pieces of even cells (not 0) that stand above their surroundings like a table: 255, else 0.
// A closed crop shows neither rows nor tracks, only its border. `elevation`: NaN where
// unseen.
cv::Mat1b RaisedFields(const cv::Mat1b& is_even,
                       const cv::Mat1f& elevation,
                       double cell_size_m,
                       const CoverOptions& options);

}  // namespace freelsd
