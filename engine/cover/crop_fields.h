// Private to cover/. Extends the sprayed ground around wheel tracks to the whole crop field.
#pragma once

#include "engine/cover/cover.h"

namespace freelsd {

// Adds the parts of a field whose tracks were not detected: cells that are connected to sprayed
// ground, have its colour, and are at most half of max_working_width_m away. One value per cell of
// `grid`: 255 in the crop field, else 0.
cv::Mat1b WithRestOfField(const cv::Mat1b& sprayed,
                          const Orthophoto& photo,
                          const Grid& grid,
                          const CoverOptions& options);

}  // namespace freelsd
