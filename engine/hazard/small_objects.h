// Private to hazard/. What stands in a meadow and is too small for the map of heights: boulders,
// animals, cars, feeders. Reed and Yu's detector of anomalies (1990) over the picture from above.
#pragma once

#include "engine/hazard/hazard.h"

namespace freelsd {

// Patches whose colour or brightness stands out of what surrounds them. Cells of the picture: 255,
// else 0.
cv::Mat1b SmallObjects(const Orthophoto& photo, const HazardOptions& options);

// Cells of `grid` with such a patch: 255, else 0. Empty without a picture.
cv::Mat1b FindSmallObjects(const Orthophoto& photo, const Grid& grid, const HazardOptions& options);

}  // namespace freelsd
