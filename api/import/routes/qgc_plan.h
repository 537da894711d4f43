// QGroundControl's .plan, version 1. Private to import/routes/.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/geometry/geometry.h"

namespace freelsd {

struct PlannedRoute {
  // Altitudes are above mean sea level.
  std::vector<GeoPoint> points;
  std::optional<double> cruise_airspeed_mps;
  std::vector<std::string> warnings;
};

// The waypoints of the mission, surveys included, in their order. A mission that begins with a
// take-off begins at home. The route ends where the landing begins, or at home if the vehicle
// returns. `pointer` is the plan's place in the body. Throws ApiError.
PlannedRoute ReadQgcPlan(const nlohmann::json& plan, const std::string& pointer);

}  // namespace freelsd
