// Planned flights -> the request for their landing insurance. Every function here treats its input
// as hostile.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "api/api.h"

namespace freelsd {

// A wind that may blow during the flight. Weights of all winds sum to 1.
struct WeightedWind {
  // East and north: where the air moves.
  Eigen::Vector2d wind_in_world = Eigen::Vector2d::Zero();
  double weight = 1.0;
};

struct RouteRequest {
  // Straight between neighbours; at least two.
  std::vector<GeoPoint> route;
  std::string altitude_datum = "unknown";
  // Whose altitudes they are: two unknown datums of one flight are equal.
  std::optional<std::string> flight_id;
  double airspeed_mps = 0.0;
  // The winds to reckon with. Empty: the wind is unknown. A wind with a standard deviation per axis
  // becomes five winds with its mean and covariance.
  std::vector<WeightedWind> winds;
  // As in emergency recall, for each of the winds. Not of the object: a wind taken from a flight
  // has them.
  double wind_sd_mps = 0.0;
  bool is_wind_old = false;
  // Empty: each site is evaluated for the aircraft for which it was planned.
  std::optional<Aircraft> aircraft;
  std::optional<double> glide_ratio;
  // As of emergency recall.
  std::optional<double> terrain_clearance_m;
  std::optional<double> arrival_height_m;
  bool has_fixes = true;
  // What of a plan is not part of the route.
  std::vector<std::string> warnings;
};

// Keys as in openapi.yaml. The route is given as `route`, or as `plan`, which is a plan of
// QGroundControl. Throws ApiError.
RouteRequest ParseRouteRequest(const nlohmann::json& object);
// True if the object itself is a plan of QGroundControl.
bool IsQgcPlan(const nlohmann::json& object);
// True if the text begins as a file of waypoints ("QGC WPL 110").
bool IsWaypoints(std::string_view text);
// The same mission as a plan. Throws ApiError with the number of the line.
nlohmann::json PlanOfWaypoints(std::string_view text);
// The JSON of a route request or of a plan, or the plan of a file of waypoints; in UTF-8 or UTF-16.
nlohmann::json ReadRouteFile(const std::string& bytes);

}  // namespace freelsd
