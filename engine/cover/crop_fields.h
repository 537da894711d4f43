// Private to cover/. From wheel tracks to the whole crop field.
#pragma once

#include "engine/cover/cover.h"

namespace freelsd {

// Undetected tracks leave parts of a field out. A cell joins the field if it is connected to
// sprayed ground, has its colour, and lies within half the width of the widest sprayer. Cells of
// `grid`: 255, else 0.
cv::Mat1b WithRestOfField(const cv::Mat1b& sprayed,
                          const Orthophoto& photo,
                          const Grid& grid,
                          const CoverOptions& options);

}  // namespace freelsd
