// Private to approach/: a region prepared for planning.
#pragma once

#include <memory>
#include <optional>

#include "engine/approach/attempt_risk.h"
#include "engine/approach/clearance_surface.h"
#include "engine/approach/refusal.h"

namespace freelsd {

// Everything that does not depend on the wind.
struct ApproachGround {
  const ElevationMap& map;
  const HazardLayers& hazards;
  PlanRequest request;
  // The aircraft as it is, and with the margins for the map's position.
  Aircraft profile;
  Aircraft aircraft;
  ApproachOptions options;
  std::shared_ptr<const RiskBasis> risk;
  double required_hazard_distance = 0.0;
  // The place farthest from hazard.
  std::optional<Touchdown> safest;
  // refusal_of_region: a reason against the region as a whole. refusal: the same reason, or else a
  // reason against every place in the region.
  std::optional<Refusal> refusal_of_region;
  std::optional<Refusal> refusal;
  TouchdownCandidates candidates;
  // Covers the whole map. Set only if several winds are planned for.
  std::optional<ClearanceSurface> surface;

  ApproachGround(const ElevationMap& the_map,
                 const HazardLayers& the_hazards,
                 const PlanRequest& the_request,
                 const Aircraft& the_aircraft,
                 const ApproachOptions& the_options);
  // The plan has no approach if the ground or the wind excludes every path.
  Plan PlanWay(const Way& way, Explanation explanation) const;
  Plan PlanWind(const std::optional<Eigen::Vector2d>& wind_in_world, Explanation explanation) const;
};

}  // namespace freelsd
