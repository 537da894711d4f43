// Private to approach/: one path against the surface.
#pragma once

#include <limits>
#include <optional>

#include "engine/approach/clearance_surface.h"

namespace freelsd {

// Where a path comes closest to what it has to clear.
struct Obstacle {
  // Top of the thing.
  Eigen::Vector3d place_in_world = Eigen::Vector3d::Zero();
  // To touchdown; of the final along it.
  double distance = 0.0;
  double clearance = 0.0;
  double wanted = 0.0;
  double Deficit() const { return wanted - clearance; }
};

// kUntilFailure stops where the verdict is known; the report wants kEverything.
enum class Depth { kUntilFailure, kEverything };

struct PathCheck {
  // Infinite where nothing was seen.
  double min_clearance = std::numeric_limits<double>::infinity();
  // Least clearance in units of the wanted one.
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
// Clearance wanted of the final at a distance to touchdown (spec 3.6), where the path is so high
// over touchdown.
double WantedClearance(double distance,
                       double path_height,
                       const ClearanceSurface& surface,
                       const Aircraft& aircraft);
// Steps around a circle: about circle_step long.
int NumCircleSteps(double radius, const ClearanceSurface& surface);
// Places that the ground roll is checked at, from touchdown outward.
struct RollSample {
  Eigen::Vector2d from_touchdown = Eigen::Vector2d::Zero();
  double distance = 0.0;
};
std::vector<RollSample> RollSamples(double heading,
                                    const ClearanceSurface& surface,
                                    const Aircraft& aircraft);

// With one more thing below the path.
PathCheck WithObstacle(PathCheck check, const Obstacle& nearest);
// The worse of two: both have to be clear.
PathCheck Worse(const PathCheck& a, const PathCheck& b);

// kUntilFailure gives the same verdict, but only a lower bound of the clearance.
// Spec 3.6: from the touchdown disc outward, corridor of path_half_width_m; wanted is the lesser of
// safety margin and half the path's height above touchdown, and what the map may lean up to there.
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
