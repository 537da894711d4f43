// One least-squares solution of a block.
#pragma once

#include <optional>
#include <vector>

#include "engine/adjustment/landmarks.h"

namespace freelsd {

struct SolverSettings {
  double loss_px = 1.5;
  // Relative change of the cost at which the solver stops.
  double function_tolerance = 1e-5;
  // Whether each view may have turned while it was read; otherwise all rows are taken as exposed at
  // once.
  bool has_readouts = true;
};

struct SolvedBlock {
  BlockState state;
  // Robust, with the priors: half of the sum.
  double cost = 0.0;
  // Of the sightings.
  int num_residuals = 0;
};

// Poses, points and, where allowed, the lens that fit inliers and priors best, starting at `start`
// and the tracks' points. `camera` is the one that was given: its intrinsics are the prior. Nothing
// when the solver fails or something is not finite; points are then of no use.
std::optional<SolvedBlock> SolveBlock(const std::vector<View>& views,
                                      const Camera& camera,
                                      const BlockState& start,
                                      const AdjustmentOptions& options,
                                      const SolverSettings& settings,
                                      std::vector<BlockTrack>& tracks);

// Whether it is not known how the camera reads its images, so that the photographs must tell.
bool IsReadoutUnknown(const Camera& camera);

// Deviations of the attitude prior, radians.
struct AttitudeDeviation {
  double tilt_sd = 0.0;
  double yaw_sd = 0.0;
};
AttitudeDeviation AttitudeDeviationOf(const View& view, const AdjustmentOptions& options);

}  // namespace freelsd
