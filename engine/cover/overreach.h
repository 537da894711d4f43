// Private to cover/. Finds where segments of meadow extend across a soft border into other ground.
#pragma once

#include "engine/cover/cover.h"

namespace freelsd {

// Finds grass cells whose colour is nearer to the surrounding other ground than to the surrounding
// grass (Fisher's discriminant of two classes). Cells where the two surroundings have nearly the
// same colour are left out. `grass`: posterior as in HazardLayers, 0 where a rule found a crop or
// water. The result has one value per cell of `grid`: 255 for a found cell, else 0.
cv::Mat1b OverreachingGrass(const cv::Mat1f& grass,
                            const Orthophoto& photo,
                            const Grid& grid,
                            const CoverOptions& options);

}  // namespace freelsd
