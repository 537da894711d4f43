// Which photographs of a block show the same ground.
#pragma once

#include <vector>

#include "engine/tracks/tracks.h"

namespace freelsd {

// Indices of views, the lower one first.
struct ViewPair {
  size_t first = 0;
  size_t second = 0;
  // Ground that both show, as a share of the smaller footprint.
  double overlap_ratio = 0.0;
};

// Pairs of views whose footprints on level ground share more than this part of the smaller one. A
// view that shows the horizon has no footprint.
std::vector<ViewPair> OverlappingPairs(const std::vector<View>& views,
                                       const Camera& camera,
                                       double min_overlap_ratio);

}  // namespace freelsd
