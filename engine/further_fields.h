// Fields that share a region's rectangle with the one its site lies in. Private to the pipeline.
#pragma once

#include <vector>

#include "engine/pipeline.h"

namespace freelsd {

// Pieces of ground within a region on which the touchdown disc fits, each as a region of its own:
// the rectangle around it, everything else as observed. Widest first, at most `max_num_fields`.
// Without the piece that holds `taken`.
std::vector<Region> FurtherFields(const Region& region,
                                  const Eigen::Vector2d& taken,
                                  const Evaluation& evaluation,
                                  double required_hazard_distance,
                                  int max_num_fields);

}  // namespace freelsd
