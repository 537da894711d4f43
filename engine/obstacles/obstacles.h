// Input: a map, its hazard layers, and obstacles that photographs do not show. Output: copies of
// both with the obstacles in them. Not in the paper: a wire is thinner than a pixel, and people
// come after the photographs.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/approach/approach.h"

namespace freelsd {

// A wire, a mast, or a place with people. Nobody may land on it, nor fly below its top.
struct HardObstacle {
  enum class Shape {
    kLine,  // through all points; one point is a mast
    kArea,  // the inside of the ring of points
  };
  std::string id;
  Shape shape = Shape::kLine;
  // World. z is the top; NaN if only its height above ground is known. Between two points the line
  // is straight. The sag of a wire is not modelled: the wire hangs lower, and the space below a
  // line counts as blocked anyway. An area is as high as its highest point.
  std::vector<Eigen::Vector3d> points_in_world;
  // Of the top. If z is known too, the higher of the two counts.
  std::optional<double> height_above_ground;
  // Standard deviation of its horizontal position.
  double position_sd_m = 0.0;
};

struct ObstacleOptions {
  // An obstacle reaches this many deviations of its position beyond its line or ring, and half the
  // diagonal of a cell.
  double position_sigma = 2.0;
  // Least height above the ground of a top whose height is not given. The altitudes of a flight and
  // of an obstacle may differ by metres, but the top of no obstacle lies in the ground.
  double min_height_m = 8.0;
  // Height above people in which nobody flies. The obstacle of a place with people has it.
  double people_height_m = 30.0;

  // Throws std::invalid_argument.
  void Check() const;
};

// How far an obstacle reaches beyond its line or ring, metres, without the share of a cell.
double ReachOf(const HardObstacle& obstacle, const ObstacleOptions& options);

// In the cells of an obstacle the upper height is at least its top, and nothing is grass. A height
// above ground counts from the cell's elevation, else from the nearest known one. Unseen cells stay
// unseen. Rasters without a change are those of the input. Hazard and distance are those of the
// input too: apply WithLimits with the aircraft's limits. Every seen cell of an obstacle is then a
// kHazard, for any limits. Throws std::invalid_argument if map and
// layers have different grids.
AssessedMap WithObstacles(const ElevationMap& map,
                          const HazardLayers& layers,
                          const std::vector<HardObstacle>& obstacles,
                          const ObstacleOptions& options);

// For pictures, on a grid of any cell size: a seen cell of an obstacle is a kHazard, and no
// distance is longer than that to the obstacle. All other layers are those of the input.
HazardLayers WithObstacleHazards(HazardLayers layers,
                                 const std::vector<HardObstacle>& obstacles,
                                 const ObstacleOptions& options);

// The plan, rejected if its circle meets an obstacle beyond the edge of the map, where the planner
// sees nothing. An obstacle inside the circle counts too: in another wind the circle is smaller.
Plan CheckedBeyondMap(Plan plan,
                      const ElevationMap& map,
                      const Aircraft& aircraft,
                      const std::vector<HardObstacle>& obstacles,
                      const ObstacleOptions& options);

// Options of a plan on a part of a map.
struct PlanOptions {
  ApproachOptions approach;
  // The plan reads the map within PlanReach of the region, with this value of `least`.
  double least_reach = 0.0;
};

// A reconstructed map to plan regions on. All references must outlive it. Not movable, because they
// may refer to its own map.
class PlannableGround {
 public:
  PlannableGround(const ElevationMap& map,
                  const HazardLayers& hazards,
                  const std::vector<HardObstacle>& obstacles,
                  const Aircraft& aircraft,
                  const HazardOptions& options);
  PlannableGround(const PlannableGround&) = delete;
  PlannableGround& operator=(const PlannableGround&) = delete;

  // With hazards for the aircraft's limits.
  const AssessedMap& with_obstacles() const { return with_obstacles_; }
  Plan PlanFor(const PlanRequest& request,
               const Aircraft& aircraft,
               const PlanOptions& options) const;
  // Nothing if there are no obstacles, or if the region is rejected without them too.
  std::optional<Plan> PlanWithoutObstacles(const PlanRequest& request,
                                           const Aircraft& aircraft,
                                           const PlanOptions& options) const;

 private:
  const ElevationMap& map_;
  const HazardLayers& hazards_;
  const std::vector<HardObstacle>& obstacles_;
  AssessedMap with_obstacles_;
};

}  // namespace freelsd
