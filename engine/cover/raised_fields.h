// Private to cover/. Detects closed crops: even fields that stand above the ground around them.
#pragma once

#include "engine/cover/cover.h"

namespace freelsd {

// Finds connected even cells (nonzero in `is_even`) that stand above their surroundings like a
// table. A closed crop shows neither rows nor tracks, so that only its border reveals it. One value
// per cell: 255 in such a field, else 0. `elevation`: NaN where unseen.
cv::Mat1b RaisedFields(const cv::Mat1b& is_even,
                       const cv::Mat1f& elevation,
                       double cell_size_m,
                       const CoverOptions& options);

// The raised share of the border of the connected even piece that holds the cell; NaN outside such
// pieces, and where less than min_raised_border_m of the border is known.
cv::Mat1f RaisedBorderRatio(const cv::Mat1b& is_even,
                            const cv::Mat1f& elevation,
                            double cell_size_m,
                            const CoverOptions& options);

}  // namespace freelsd
