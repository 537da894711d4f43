// Which photographs of a block show the same ground.
#pragma once

#include <utility>
#include <vector>

#include "engine/tracks/tracks.h"

namespace freelsd {

using ViewPair = std::pair<size_t, size_t>;

// Pairs of views whose footprints on level ground share more than this part of the smaller one,
// lower index first. A view that shows the horizon has no footprint.
std::vector<ViewPair> OverlappingPairs(const std::vector<View>& views,
                                       const Camera& camera,
                                       double min_overlap_ratio);

}  // namespace freelsd
