// Private to cover/. Finds where segments of meadow extend across a soft border into other ground.
#pragma once

#include "engine/cover/cover.h"

namespace freelsd {

// Grass cells whose colour is nearer to that of the surrounding non-grass than to that of the
// surrounding grass, where these two colours differ (Fisher's discriminant of two classes).
// `grass`: posterior as in HazardLayers, 0 where a rule found a crop or water. Result in cells of
// `grid`: 255, else 0.
cv::Mat1b OverreachingGrass(const cv::Mat1f& grass,
                            const Orthophoto& photo,
                            const Grid& grid,
                            const CoverOptions& options);

}  // namespace freelsd
