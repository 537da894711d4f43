// Private to hazard/. Where segments of meadow reach over a soft border into other ground.
#pragma once

#include "engine/hazard/hazard.h"

namespace freelsd {

// Cells called grass whose colour is nearer to that of the ground told to be none around them than
// to that of the grass around them, where these two are apart (Fisher's discriminant of two
// classes). `grass` as in HazardLayers, 0 where a rule has told a crop or water. Cells of `grid`:
// 255, else 0.
cv::Mat1b OverreachingGrass(const cv::Mat1f& grass,
                            const Orthophoto& photo,
                            const Grid& grid,
                            const HazardOptions& options);

}  // namespace freelsd
