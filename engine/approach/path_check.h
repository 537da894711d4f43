// Private to approach/: checks one path against the surface.
#pragma once

#include <limits>
#include <optional>

#include "engine/approach/clearance_surface.h"

namespace freelsd {

// Place where a path lacks most clearance.
struct Obstacle {
  // Top of the obstacle.
  Eigen::Vector3d place_in_world = Eigen::Vector3d::Zero();
  // Distance to touchdown; on the final, measured along it.
  double distance = 0.0;
  double clearance = 0.0;
  double wanted = 0.0;
  double Deficit() const { return wanted - clearance; }
};

// kUntilFailure stops as soon as the verdict is known; reports need kEverything.
enum class Depth { kUntilFailure, kEverything };

struct PathCheck {
  // Infinity if nothing was seen.
  double min_clearance = std::numeric_limits<double>::infinity();
  // Least ratio of clearance to the clearance needed.
  double min_clearance_ratio = std::numeric_limits<double>::infinity();
  // The worst one, if the path is blocked.
  std::optional<Obstacle> obstacle;
  int num_steps = 0;
  int num_unseen_steps = 0;
  // Distance to touchdown of the unseen step nearest to it (final only).
  double first_unseen_distance = 0.0;
  // Share of the final, from touchdown on, that is seen and clear.
  double clear_ratio = 1.0;

  double UnseenRatio() const {
    return num_steps == 0 ? 0.0 : static_cast<double>(num_unseen_steps) / num_steps;
  }
};

// Distances to touchdown at which the final is checked, ascending, both ends included.
std::vector<double> FinalSteps(const ClearanceSurface& surface,
                               const WindScenario& scenario,
                               const Aircraft& aircraft,
                               const ApproachOptions& options);
// Clearance that the final needs at a distance from touchdown, where the path is path_height above
// touchdown (decision 0019).
double WantedClearance(double distance,
                       double path_height,
                       const ClearanceSurface& surface,
                       const Aircraft& aircraft);
// Number of steps around a circle, each about circle_step long.
int NumCircleSteps(double radius, const ClearanceSurface& surface);
// Samples of the ground roll, from touchdown outward.
struct RollSample {
  Eigen::Vector2d from_touchdown = Eigen::Vector2d::Zero();
  double distance = 0.0;
};
std::vector<RollSample> RollSamples(double heading,
                                    const ClearanceSurface& surface,
                                    const Aircraft& aircraft);

// The check with one more obstacle below the path.
PathCheck WithObstacle(PathCheck check, const Obstacle& nearest);
// The worse of two checks: both must be clear.
PathCheck Worse(const PathCheck& a, const PathCheck& b);

// kUntilFailure gives the same verdict, but only a lower bound of the clearance. Starts at the edge
// of the touchdown disc; corridor of path_half_width_m. The clearance needed is the lesser of
// safety margin and half the path's height, plus the map's lean (decision 0019).
PathCheck CheckFinal(const Approach& approach,
                     const ClearanceSurface& surface,
                     const Aircraft& aircraft,
                     const ApproachOptions& options,
                     Depth depth);

PathCheck CheckCircle(const Approach& approach,
                      const ClearanceSurface& surface,
                      const Aircraft& aircraft);

// First cell of the strip behind touchdown that is not free.
struct RollHazard {
  Eigen::Vector2d place_in_world = Eigen::Vector2d::Zero();
  double distance = 0.0;
  bool is_unseen = false;
};
std::optional<RollHazard> CheckGroundRoll(const Eigen::Vector3d& touchdown_in_world,
                                          double heading,
                                          const ClearanceSurface& surface,
                                          const Aircraft& aircraft);

ApproachProfile MakeProfile(const Approach& approach,
                            const ClearanceSurface& surface,
                            const Aircraft& aircraft,
                            const ApproachOptions& options);

}  // namespace freelsd
