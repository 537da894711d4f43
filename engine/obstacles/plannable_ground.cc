#include "engine/obstacles/obstacles.h"

namespace freelsd {
namespace {

// A plan on a stored map reads the same part of it.
AssessedMap WindowFor(const AssessedMap& whole,
                      const PlanRequest& request,
                      const Aircraft& aircraft,
                      const PlanOptions& options) {
  const double reach = PlanReach(aircraft,
                                 request.wind_in_world,
                                 request.wind_spread_mps,
                                 options.least_reach,
                                 options.approach);
  const cv::Rect cells = whole.map.grid.CellsAround(request.footprint, reach);
  return WindowOf(whole.map, whole.layers, cells);
}

}  // namespace

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
                              const PlanOptions& options) const {
  const AssessedMap window = WindowFor(with_obstacles_, request, aircraft, options);
  return CheckedBeyondMap(
      PlanApproach(window.map, window.layers, request, aircraft, options.approach),
      window.map,
      aircraft,
      obstacles_,
      {});
}

std::optional<Plan> PlannableGround::PlanWithoutObstacles(const PlanRequest& request,
                                                          const Aircraft& aircraft,
                                                          const PlanOptions& options) const {
  if (obstacles_.empty()) return std::nullopt;
  const AssessedMap window = WindowFor({map_, hazards_}, request, aircraft, options);
  Plan plan = PlanApproach(window.map, window.layers, request, aircraft, options.approach);
  if (plan.verdict == Verdict::kRejected) return std::nullopt;
  return plan;
}

}  // namespace freelsd
