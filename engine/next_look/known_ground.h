// Private to next_look/: what is known of the ground, in coarse cells, and what is expected of the
// rest.
#pragma once

#include "engine/next_look/next_look.h"

namespace freelsd {

// Rasters over the area of the legs and what they could show, of coarse cells.
struct KnownGround {
  Grid grid;
  // Share of the cell that is known, 0 to 1, and that is free.
  cv::Mat1f known, free;
  // Photographs so far that show the cell, whether they made it known or not.
  cv::Mat1f num_shown;
  // Probability that ground which is not known fits a touchdown disc; that nothing there stands in
  // the way of a path.
  cv::Mat1f fit_prospect, low_prospect;
  // World z: the ground (expected where unseen), the highest of what is refused and
  // the highest top of all. -infinity where there is none.
  cv::Mat1f height, obstacle_top, top;
  // Distance to ground that is surely no landing ground, metres, from the best place of the cell;
  // infinity outside the map.
  cv::Mat1f clear_distance;
  // The planner's least distance of a touchdown from hazard, and half the width of its corridors.
  double disc_radius_m = 0.0;
  double corridor_half_width_m = 0.0;
};

// `area`: the grid covers it.
KnownGround MeasureKnownGround(const LookRequest& request,
                               const Box& area,
                               const NextLookOptions& options);

}  // namespace freelsd
