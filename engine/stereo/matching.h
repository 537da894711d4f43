// Semi-global matching of a rectified pair (Hirschmueller 2008).
#pragma once

#include "engine/stereo/rectification.h"

namespace freelsd {

// Left column minus right column per pixel of the left image; NaN without a reliable match.
cv::Mat1f MatchRectified(const RectifiedPair& pair,
                         const DepthRange& depths,
                         const StereoOptions& options);

}  // namespace freelsd
