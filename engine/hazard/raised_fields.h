// Private to hazard/. Even ground that is no ground: a closed crop, seen from above.
#pragma once

#include "engine/hazard/hazard.h"

namespace freelsd {

// Of the even cells (not 0), those of pieces that stand above what lies around like a table: 255,
// else 0. A crop whose leaves have met has neither rows nor tracks; its border is all that tells.
// `elevation`: NaN where unseen.
cv::Mat1b RaisedFields(const cv::Mat1b& is_even,
                       const cv::Mat1f& elevation,
                       double cell_size_m,
                       const HazardOptions& options);

}  // namespace freelsd
