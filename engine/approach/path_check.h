// Private to approach/: checks one path against the clearance surface.
#pragma once

#include <limits>
#include <optional>

#include "engine/approach/clearance_surface.h"
#include "engine/approach/corridor.h"

namespace freelsd {

// The place with the largest deficit of clearance.
struct Obstacle {
  // Highest point of the obstacle.
  Eigen::Vector3d place_in_world = Eigen::Vector3d::Zero();
  // Distance to touchdown. On the final approach it is measured along the path.
  double distance = 0.0;
  double clearance = 0.0;
  double wanted = 0.0;
  double Deficit() const { return wanted - clearance; }
};

// kUntilFailure stops as soon as the verdict is known. A report needs kEverything.
enum class Depth { kUntilFailure, kEverything };

struct PathCheck {
  // Infinity if the map shows nothing below the path.
  double min_clearance = std::numeric_limits<double>::infinity();
  // Least ratio of clearance to the clearance needed.
  double min_clearance_ratio = std::numeric_limits<double>::infinity();
  // The obstacle with the largest deficit; nothing if none blocks the path.
  std::optional<Obstacle> obstacle;
  int num_steps = 0;
  int num_unseen_steps = 0;
  // Final approach only: distance to touchdown of the nearest unseen step.
  double first_unseen_distance = 0.0;
  // Share of the final approach, counted from touchdown, that is seen and clear.
  double clear_ratio = 1.0;

  double UnseenRatio() const {
    return num_steps == 0 ? 0.0 : static_cast<double>(num_unseen_steps) / num_steps;
  }
};

// One slice across a corridor.
struct Slice {
  // World z; kNoHeight where no cell shows a height.
  float height = kNoHeight;
  int row = 0;  // of the highest cell
  int col = 0;
  // A cell is unseen or lies off the map.
  bool is_unseen = false;
  bool is_on_map = false;
  // All cells are kFree.
  bool is_free = true;
};
Slice SliceAt(const Eigen::Vector2d& place,
              const Corridor& corridor,
              const ClearanceSurface& surface);
// Distance between slices along a straight path, metres.
double AlongStep(const ClearanceSurface& surface, const ApproachOptions& options);

// Distances to touchdown at which the final approach is checked, ascending, both ends included.
std::vector<double> FinalSteps(const ClearanceSurface& surface,
                               const WindScenario& scenario,
                               const Aircraft& aircraft,
                               const ApproachOptions& options);
// Clearance that the final approach needs at a distance from touchdown. `path_height` is the height
// of the path above touchdown there (decision 0019).
double WantedClearance(double distance,
                       double path_height,
                       const ClearanceSurface& surface,
                       const Aircraft& aircraft);
// Number of steps around a circle, each about circle_step long.
int NumCircleSteps(double radius, const ClearanceSurface& surface);
// Sample points of the ground roll, ordered by distance from touchdown.
struct RollSample {
  Eigen::Vector2d from_touchdown = Eigen::Vector2d::Zero();
  double distance = 0.0;
};
std::vector<RollSample> RollSamples(double heading,
                                    const ClearanceSurface& surface,
                                    const Aircraft& aircraft);

// Adds one more obstacle below the path to the check.
PathCheck WithObstacle(PathCheck check, const Obstacle& nearest);
// Combines two checks into the worst case, because both paths must be clear.
PathCheck Worse(const PathCheck& a, const PathCheck& b);

// Distance to touchdown up to which all ground below the final is kFree, across the whole corridor
// and without a gap from the edge of the touchdown disc. 0 if there is none.
double FreeRun(const Approach& approach,
               const ClearanceSurface& surface,
               const Aircraft& aircraft,
               const ApproachOptions& options);

// With kUntilFailure the verdict is the same, but the clearance is only a lower bound. The check
// starts at the edge of the touchdown disc. The corridor's half-width is path_half_width_m. The
// needed clearance is the lesser of the safety margin and half the path's height, plus an amount
// for the tilt of the map (decision 0019). The free run needs no clearance: an
// aircraft that comes down early there lands short.
PathCheck CheckFinal(const Approach& approach,
                     const ClearanceSurface& surface,
                     const Aircraft& aircraft,
                     const ApproachOptions& options,
                     Depth depth);

PathCheck CheckCircle(const Approach& approach,
                      const ClearanceSurface& surface,
                      const Aircraft& aircraft);

// First cell of the ground roll, beyond touchdown, that is not kFree.
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
