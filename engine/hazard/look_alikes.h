// Private to hazard/. What looks like a meadow, and is not: told by the picture from above, where
// colour and texture of a patch cannot tell (spec 3.6).
#pragma once

#include "engine/hazard/hazard.h"

namespace freelsd {

// Cells of `grid` on which one of the rules below holds: 255, else 0. Empty without a picture.
cv::Mat1b FindLookAlikes(const Orthophoto& photo, const Grid& grid, const HazardOptions& options);

// Crops in rows (maize, beets, potatoes, vines): one direction and one distance stand out of the
// spectrum of the picture all over a field. Cells of the picture: 255, else 0.
cv::Mat1b RowCrops(const Orthophoto& photo, const HazardOptions& options);

// Water with a cover of algae, which is green and even: nothing on it is as small as a tuft.
// Cells of the picture: 255, else 0.
cv::Mat1b StillWater(const Orthophoto& photo, const HazardOptions& options);

}  // namespace freelsd
