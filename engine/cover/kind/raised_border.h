// Private to kind/. How much of the border of an even field stands above the ground around it: a
// closed crop shows neither rows nor tracks, and may be told by its border alone.
#pragma once

#include <opencv2/core.hpp>

namespace freelsd {

// The share of the known border of the connected even piece (nonzero in `is_even`) that holds the
// cell, where the piece stands above its surroundings like a table. NaN outside such pieces, and
// where too little of the border is known. `elevation`: NaN where unseen.
cv::Mat1f RaisedBorderRatio(const cv::Mat1b& is_even,
                            const cv::Mat1f& elevation,
                            double cell_size_m);

}  // namespace freelsd
