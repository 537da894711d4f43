#include "engine/approach/tightest_obstacle.h"

#include "engine/approach/corridor.h"

namespace freelsd {
namespace {

// One step of a path.
struct Step {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  // World z.
  double height = 0.0;
  // Distance to touchdown, and the clearance that is needed at this step.
  double distance = 0.0;
  double wanted = 0.0;
};

// Largest height of the ground that the aircraft lands on, world z.
struct GroundHeights {
  double free = 0.0;
  double not_free = 0.0;
};

GroundHeights HeightsAround(const Approach& approach, const Aircraft& aircraft) {
  const double touchdown = approach.touchdown_in_world.z();
  return {touchdown + aircraft.safety_margin_m, touchdown + aircraft.max_roughness_m};
}

bool IsObstacle(const ClearanceSurface& surface, int row, int col, const GroundHeights& ground) {
  const bool is_free = surface.hazard(row, col) == kFree;
  return surface.height(row, col) > (is_free ? ground.free : ground.not_free);
}

// The highest obstacle across the path at a step.
std::optional<PathObstacle> HighestAcross(const Step& step,
                                          const Corridor& corridor,
                                          const ClearanceSurface& surface,
                                          const GroundHeights& ground) {
  std::optional<PathObstacle> highest;
  for (int i = -corridor.num_each_side; i <= corridor.num_each_side; ++i) {
    const Eigen::Vector2d sample = step.place + (i * corridor.spacing) * corridor.across;
    const int row = surface.RowAt(sample.y()), col = surface.ColAt(sample.x());
    if (!surface.IsInside(row, col)) continue;
    if (!IsObstacle(surface, row, col, ground)) continue;
    const double top = surface.height(row, col);
    if (highest && top <= highest->place_in_world.z()) continue;
    const Eigen::Vector2d center = surface.CellCenter(row, col);
    highest = PathObstacle{.place_in_world = {center.x(), center.y(), top},
                           .distance = step.distance,
                           .clearance = step.height - top,
                           .wanted = step.wanted};
  }
  return highest;
}

}  // namespace

std::optional<PathObstacle> Tighter(const std::optional<PathObstacle>& a,
                                    const std::optional<PathObstacle>& b) {
  if (!a || !b) return a ? a : b;
  return b->clearance - b->wanted < a->clearance - a->wanted ? b : a;
}

std::optional<PathObstacle> TightestOnFinal(const Approach& approach,
                                            const ClearanceSurface& surface,
                                            const Aircraft& aircraft,
                                            const ApproachOptions& options) {
  const Corridor corridor =
      MakeCorridor(approach.heading, aircraft.path_half_width_m, surface.cell_size);
  const Eigen::Vector2d forward = DirectionOf(approach.heading);
  const Eigen::Vector2d touchdown = approach.touchdown_in_world.head<2>();
  const double slope = approach.approach_height / approach.approach_distance;
  const WindScenario scenario{approach.approach_distance, approach.loiter_radius};
  const double free_run = FreeRun(approach, surface, aircraft, options);
  std::optional<PathObstacle> tightest;
  for (const double distance : FinalSteps(surface, scenario, aircraft, options)) {
    if (distance <= free_run) continue;
    const double path = slope * distance;
    const Step step{.place = touchdown - distance * forward,
                    .height = approach.touchdown_in_world.z() + path,
                    .distance = distance,
                    .wanted = WantedClearance(distance, path, surface, aircraft)};
    tightest = Tighter(tightest,
                       HighestAcross(step, corridor, surface, HeightsAround(approach, aircraft)));
  }
  return tightest;
}

std::optional<PathObstacle> TightestOnCircle(const Approach& approach,
                                             const ClearanceSurface& surface,
                                             const Aircraft& aircraft) {
  const int num_steps = NumCircleSteps(approach.loiter_radius, surface);
  const Eigen::Vector2d center = approach.loiter_center_in_world.head<2>();
  const Eigen::Matrix2d rotation = Eigen::Rotation2Dd(2.0 * kPi / num_steps).toRotationMatrix();
  Eigen::Vector2d arm = approach.approach_start_in_world.head<2>() - center;
  // As wide as in the check of the circle.
  Corridor corridor =
      MakeCorridor(0.0, surface.corridor_radius - surface.HalfDiagonal(), surface.cell_size);
  std::optional<PathObstacle> tightest;
  for (int i = 0; i < num_steps; ++i, arm = rotation * arm) {
    corridor.across = arm.normalized();
    const Eigen::Vector2d place = center + arm;
    const double distance = (place - approach.touchdown_in_world.head<2>()).norm();
    const Step step{.place = place,
                    .height = approach.loiter_center_in_world.z(),
                    .distance = distance,
                    .wanted = aircraft.safety_margin_m + surface.lean * distance};
    tightest = Tighter(tightest,
                       HighestAcross(step, corridor, surface, HeightsAround(approach, aircraft)));
  }
  if (tightest) tightest->part = PathPart::kCircle;
  return tightest;
}

}  // namespace freelsd
