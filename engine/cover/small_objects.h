// Private to cover/. Objects in a meadow that the elevation map does not show: boulders, animals,
// cars, feeders. Anomaly detector of Reed and Yu (1990) on the orthophoto.
#pragma once

#include "engine/cover/cover.h"

namespace freelsd {

// Patches whose colour or brightness differs from their surroundings. One value per cell of the
// orthophoto: 255 in a patch, 0 elsewhere.
cv::Mat1b SmallObjects(const Orthophoto& photo, const CoverOptions& options);

// One value per cell of `grid`: 255 if the cell contains such a patch, else 0. Empty if the
// orthophoto is empty or the search is off.
cv::Mat1b FindSmallObjects(const Orthophoto& photo, const Grid& grid, const CoverOptions& options);

}  // namespace freelsd
