// Adjustment of views that do not all hang together: groups that see the same ground are tied.
#pragma once

#include <vector>

#include "engine/adjustment/adjustment.h"
#include "engine/flight/flight.h"
#include "engine/tracks/tracks.h"

namespace freelsd {

// As AdjustPoses. Where the block comes out in several groups of views, or leaves views out, their
// photographs are matched once more on the ground, and what is found is adjusted with the rest. The
// answer is the block that ties the most views into one group.
AdjustedBlock AdjustAndTie(const std::vector<View>& views,
                           const Camera& camera,
                           const ImageSource& images,
                           const TracksOptions& tracks,
                           const AdjustmentOptions& options);

}  // namespace freelsd
