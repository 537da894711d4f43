// Checks of paths and strips against the map. What was not seen is never clear.
#pragma once

#include <optional>
#include <vector>

#include "engine/approach/approach.h"
#include "engine/approach/flight_path.h"

namespace freelsd {

// The surface that a path must clear, prepared once per map.
struct ObstacleSurface {
  Grid grid;
  // Upper height plus the allowance for what is seen through; NaN where unseen.
  cv::Mat1f height;
  // Highest within path_half_width of the cell; NaN where any of that is unseen.
  cv::Mat1f dilated;
  // The same, but of the seen part only; NaN where nothing of it was seen.
  cv::Mat1f dilated_seen;
};

ObstacleSurface MakeObstacleSurface(const ElevationMap& map,
                                    const HazardLayers& hazards,
                                    const Aircraft& aircraft,
                                    const ApproachOptions& options);

struct FinalCheck {
  // What stands in the way first, seen from touchdown; none when the final is seen and clear.
  std::optional<RejectReason> reason;
  // Where the reason lies: distance to touchdown, and the place.
  double distance = 0.0;
  Eigen::Vector3d place_in_world = Eigen::Vector3d::Zero();
  // Over the seen part outside the touchdown disc; and how much was missing there at worst.
  double min_clearance = 0.0;
  double worst_shortage = 0.0;
  ApproachProfile profile;
};

// From touchdown_uncertainty_m outwards, in a corridor of path_half_width_m.
FinalCheck CheckFinal(const ObstacleSurface& surface,
                      const Approach& approach,
                      const Aircraft& aircraft,
                      const ApproachOptions& options);

struct CircleCheck {
  bool is_blocked = false;
  double unseen_ratio = 0.0;
  // Least clearance over the seen part; +infinity where nothing was seen.
  double min_clearance = 0.0;
  Eigen::Vector3d obstacle_in_world = Eigen::Vector3d::Zero();
};

CircleCheck CheckCircle(const ObstacleSurface& surface,
                        const Approach& approach,
                        LoiterDirection direction,
                        const Aircraft& aircraft,
                        const ApproachOptions& options);

// First place on the ground-roll strip behind touchdown that is hazard or unseen.
std::optional<Eigen::Vector3d> HazardOnStrip(const ElevationMap& map,
                                             const HazardLayers& hazards,
                                             const Leg& leg,
                                             const Aircraft& aircraft);

}  // namespace freelsd
