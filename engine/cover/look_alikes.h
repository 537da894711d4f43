// Private to cover/. Finds ground that looks like a meadow but is a crop or water. The orthophoto
// shows patterns that a single patch cannot show (decisions 0010 and 0012).
#pragma once

#include "engine/cover/cover.h"

namespace freelsd {

// One value per cell of `grid`: 255 if the cell contains crops in rows or still
// water, else 0. Empty if the orthophoto is empty.
cv::Mat1b FindLookAlikes(const Orthophoto& photo, const Grid& grid, const CoverOptions& options);

// Crops in rows (maize, beets, potatoes, vines): one direction and one spacing dominate the
// spectrum across the whole field. One value per cell of the orthophoto: 255 or 0.
cv::Mat1b RowCrops(const Orthophoto& photo, const CoverOptions& options);

// Water covered with algae is green and even, but lacks detail as fine as a tuft of grass. One
// value per cell of the orthophoto: 255 or 0.
cv::Mat1b StillWater(const Orthophoto& photo, const CoverOptions& options);

}  // namespace freelsd
