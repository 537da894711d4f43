// Finds where a photograph with an inexact pose shows the stored ground.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "engine/watch/strip_canvas.h"

namespace freelsd {

struct StripRegistration {
  // To be used with Project.
  Displacement displacement;
  // Of the matches that agree.
  double correlation = 0.0;
  // Root mean square distance from the common motion, metres.
  double error_m = 0.0;
  // Squares that agree, and all that both pictures show.
  int num_matches = 0;
  int num_tried = 0;
};

// Nothing if the pictures have too little in common.
std::optional<StripRegistration> Register(const WatchedPhoto& photo,
                                          const StripGround& ground,
                                          const StripCanvas& canvas,
                                          const WatchOptions& options);

}  // namespace freelsd
