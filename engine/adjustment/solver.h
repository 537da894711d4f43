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
  // Powers of time in each view's turn during readout. 0: all rows are exposed at once.
  int num_turns = 0;
};

struct SolvedBlock {
  BlockState state;
  // Half of the sum of all squared residuals after the robust loss function, including priors.
  double cost = 0.0;
  // Number of residuals of sightings, without those of priors.
  int num_residuals = 0;
};

// Finds the poses and the points that fit the inliers and the priors best. If
// refine_exif_intrinsics allows it, also finds the best lens. Initial values are `start` and the
// points in `tracks`. `camera` holds the prior intrinsics. Writes the result's points to `tracks`.
// Nothing if the solver fails or a value is not finite. The points in `tracks` are then invalid.
std::optional<SolvedBlock> SolveBlock(const std::vector<View>& views,
                                      const Camera& camera,
                                      const BlockState& start,
                                      const AdjustmentOptions& options,
                                      const SolverSettings& settings,
                                      std::vector<BlockTrack>& tracks);

// Whether the readout time is unknown and must be estimated from the photographs.
bool IsReadoutUnknown(const Camera& camera);

// Deviations of the attitude prior, radians.
struct AttitudeDeviation {
  double tilt_sd = 0.0;
  double yaw_sd = 0.0;
};
AttitudeDeviation AttitudeDeviationOf(const View& view, const AdjustmentOptions& options);

}  // namespace freelsd
