// Private to cover/. Where segments of meadow reach over a soft border into other ground.
#pragma once

#include "engine/cover/cover.h"

namespace freelsd {

// Grass cells whose colour is nearer to the surrounding non-grass than to the
// surrounding grass, where these two differ (Fisher's discriminant of two classes).
// `grass` as in HazardLayers, 0 where a rule found a crop or water. Cells of `grid`:
// 255, else 0.
cv::Mat1b OverreachingGrass(const cv::Mat1f& grass,
                            const Orthophoto& photo,
                            const Grid& grid,
                            const CoverOptions& options);

}  // namespace freelsd
