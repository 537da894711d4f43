// Private to cover/. Finds ground that looks like a meadow but is a crop or water. The orthophoto
// shows patterns that a single patch cannot show (decisions 0010 and 0012).
#pragma once

#include "engine/cover/cover.h"

namespace freelsd {

// What the views say of the map's cells, before any rule.
struct ToldKinds {
  cv::Mat1f grass;
  // The likeliest of the other kinds (LikelyKind).
  cv::Mat1b other;
};

// One value per cell of `grid`: 255 if the cell contains crops in rows and the views are not quite
// sure of grass (max_row_posterior), or still water where the views, too, take it for water if not
// for grass, and are not sure of grass (max_still_water_posterior); else 0. Empty if the orthophoto
// is empty.
cv::Mat1b FindLookAlikes(const Orthophoto& photo,
                         const Grid& grid,
                         const ToldKinds& told,
                         const CoverOptions& options);

// Crops in rows (maize, beets, potatoes, vines): one direction and one spacing dominate the
// spectrum across the whole field. One value per cell of the orthophoto: 255 or 0.
cv::Mat1b RowCrops(const Orthophoto& photo, const CoverOptions& options);

// Water covered with algae is green and even, but lacks detail as fine as a tuft of grass; so does
// grass that is photographed softly. One
// value per cell of the orthophoto: 255 or 0.
cv::Mat1b StillWater(const Orthophoto& photo, const CoverOptions& options);

}  // namespace freelsd
