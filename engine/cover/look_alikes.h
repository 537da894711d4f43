// Private to cover/. Ground that looks like a meadow and is not one: crops and water. The
// orthophoto shows what one patch cannot (decisions 0010 and 0012).
#pragma once

#include "engine/cover/cover.h"

namespace freelsd {

// Cells of `grid` where one of the rules below applies: 255, else 0. Empty without an orthophoto.
cv::Mat1b FindLookAlikes(const Orthophoto& photo, const Grid& grid, const CoverOptions& options);

// Crops in rows (maize, beets, potatoes, vines): one direction and one spacing dominate the
// spectrum over a whole field. Cells of the orthophoto: 255, else 0.
cv::Mat1b RowCrops(const Orthophoto& photo, const CoverOptions& options);

// Water under algae, which is green and even: it lacks detail as fine as a tuft of grass. Cells of
// the orthophoto: 255, else 0.
cv::Mat1b StillWater(const Orthophoto& photo, const CoverOptions& options);

}  // namespace freelsd
