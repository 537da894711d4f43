// Private to cover/. Detects closed crops: even fields that stand above the ground around them.
#pragma once

#include "engine/cover/cover.h"

namespace freelsd {

// Connected even cells (nonzero in `is_even`) that stand above their surroundings like a table:
// 255, else 0. A closed crop shows neither rows nor tracks; only its border reveals it.
// `elevation`: NaN where unseen.
cv::Mat1b RaisedFields(const cv::Mat1b& is_even,
                       const cv::Mat1f& elevation,
                       double cell_size_m,
                       const CoverOptions& options);

}  // namespace freelsd
