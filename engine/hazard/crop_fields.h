// Private to hazard/. From what wheel tracks tell of a crop to the field it is.
#pragma once

#include "engine/hazard/hazard.h"

namespace freelsd {

// Tracks that were not found, or of which only the round along the border was, leave parts of a
// field. What hangs together with sprayed ground, is of its colour, and lies within half of the
// widest sprayer of it, is of the same field. Cells of `grid`: 255, else 0.
cv::Mat1b WithRestOfField(const cv::Mat1b& sprayed,
                          const Orthophoto& photo,
                          const Grid& grid,
                          const HazardOptions& options);

}  // namespace freelsd
