// Private to cover/. Where photographs of one place show different things.
#pragma once

#include "engine/cover/cover.h"

namespace freelsd {

// Cover that is known before photographs are compared. Cells of the map: 255, else 0.
struct MeadowCells {
  cv::Mat1b is_clear_class;
  // Counts as meadow around a lone thing, whatever other rules find there.
  cv::Mat1b is_meadow;
  // Objects that differ from the ground around them; may be empty.
  cv::Mat1b objects;
};

// The map has the ground's height below a leafless crown, but the twigs move against the
// ground from view to view. The deviation of the height is unknown where two photographs
// differ, or where only one shows the place. Narrow cover and lone objects get an allowance
// instead. Cells of a clear class are left alone: grass is no tree. An orthophoto of one view
// is not compared.
OpenCover FindOpenCover(const Orthophoto& photo,
                        const Grid& grid,
                        const MeadowCells& cells,
                        const PhotoOptions& options);

}  // namespace freelsd
