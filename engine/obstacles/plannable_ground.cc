#include "engine/obstacles/obstacles.h"

namespace freelsd {

PlannableGround::PlannableGround(const ElevationMap& map,
                                 const HazardLayers& hazards,
                                 const std::vector<HardObstacle>& obstacles,
                                 const Aircraft& aircraft,
                                 const HazardOptions& options)
    : map_(map), hazards_(hazards), obstacles_(obstacles), with_obstacles_{map, hazards} {
  if (obstacles.empty() || map.elevation.empty()) return;
  with_obstacles_ = WithObstacles(map, hazards, obstacles, {});
  with_obstacles_.layers = WithLimits(with_obstacles_.map,
                                      with_obstacles_.layers,
                                      {aircraft.max_slope_deg, aircraft.max_roughness_m},
                                      options);
}

Plan PlannableGround::PlanFor(const PlanRequest& request,
                              const Aircraft& aircraft,
                              const ApproachOptions& options) const {
  return CheckedBeyondMap(
      PlanApproach(with_obstacles_.map, with_obstacles_.layers, request, aircraft, options),
      with_obstacles_.map,
      aircraft,
      obstacles_,
      {});
}

std::optional<Plan> PlannableGround::PlanWithoutObstacles(const PlanRequest& request,
                                                          const Aircraft& aircraft,
                                                          const ApproachOptions& options) const {
  if (obstacles_.empty()) return std::nullopt;
  Plan plan = PlanApproach(map_, hazards_, request, aircraft, options);
  if (plan.verdict == Verdict::kRejected) return std::nullopt;
  return plan;
}

}  // namespace freelsd
