// Private to heights/. The views that are compared at a place.
#pragma once

#include <vector>

#include "engine/adjustment/adjustment.h"
#include "engine/heights/heights.h"

namespace freelsd {

struct ChosenViews {
  // Indices into AdjustedBlock::views, of one group.
  std::vector<size_t> views;
  // Widest baseline over height.
  double baseline_ratio = 0.0;
};

// Of the views that see the place, those of the largest group that spread widest: first the
// steepest, then one after the other the one whose camera is farthest from those chosen.
ChosenViews ChooseViews(const AdjustedBlock& block,
                        const std::vector<size_t>& seeing,
                        const Eigen::Vector3d& place_in_world,
                        int max_num_views);

}  // namespace freelsd
