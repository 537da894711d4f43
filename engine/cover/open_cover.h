// Private to cover/. Compares two photographs of each place to find cover that the map misses.
#pragma once

#include "engine/cover/cover.h"

namespace freelsd {

// Cover that is known before photographs are compared. One value per map cell: 255 for true, 0 for
// false.
struct MeadowCells {
  cv::Mat1b is_clear_class;
  // Cells that count as meadow around a lone object, even if other rules exclude them.
  cv::Mat1b is_meadow;
  // Objects that differ from the ground around them; the raster may be empty.
  cv::Mat1b objects;
};

// Deviation of the log ratio of the two photographs' brightness, by cell of the map; NaN unless
// both show the cell. Empty if the orthophoto has no second image.
cv::Mat1f PhotoDisagreement(const Orthophoto& photo, const Grid& grid);

// Below a leafless crown the map has the height of the ground, but the twigs shift relative to the
// ground from view to view. Where two photographs differ, or fewer than two show the place, the
// height's standard deviation becomes unknown. Over narrow cover and lone objects, the upper height
// is raised instead. Differences in cells with a clear class (ClearClassOptions) are ignored: no
// tree stands there. Nothing is compared if `disagreement` is empty.
OpenCover FindOpenCover(const cv::Mat1f& disagreement,
                        const Grid& grid,
                        const MeadowCells& cells,
                        const PhotoOptions& options);

}  // namespace freelsd
