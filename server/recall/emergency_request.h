// A request to emergency recall, and its parser. Emergency recall finds stored landing sites for an
// aircraft without power.
#pragma once

#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "api/api.h"
#include "engine/flight/flight.h"
#include "engine/glide/glide.h"
#include "server/recall/altitude_datum.h"
#include "server/recall/live_pose/live_pose.h"

namespace freelsd {

// State of the aircraft, and the largest number of sites in the answer.
struct EmergencyRequest {
  GeoPoint place;
  // "amsl", "ellipsoid" or "unknown"; empty: not given. It is then taken from the flight; without a
  // flight it is unknown.
  std::optional<std::string> altitude_datum;
  // The flight that measured the altitude. Values that are not given may be taken from this flight.
  std::optional<std::string> flight_id;
  // The flight's memory is "none": its own sites and maps count too, for this request alone.
  bool is_of_experiment = false;
  // East and north, m/s: the direction in which the air moves. Empty: unknown.
  std::optional<Eigen::Vector2d> wind_in_world;
  // Standard deviation of the wind in each axis; 0: unknown.
  double wind_sd_mps = 0.0;
  // As in WindOfNow: nothing is landable in an old wind. Never of a wind that was given.
  bool is_wind_old = false;
  std::optional<std::string> wind_warning = std::nullopt;
  std::optional<double> heading_deg;
  std::optional<double> glide_ratio;
  // The least touchdown_uncertainty_m to plan for: an autopilot may need more than a pilot.
  double touchdown_uncertainty_m = 0.0;
  // Safety heights: above the stored terrain below the path, and above the start of the final.
  double terrain_clearance_m = GlideOptions{}.terrain_clearance_m;
  double arrival_height_m = 0.0;
  // Empty: each site is evaluated for the aircraft for which it was planned.
  std::optional<Aircraft> aircraft;
  size_t limit = 5;
};

// The request's altitude, for comparison with stored altitudes. The result refers to texts in
// `request`.
AltitudeReference ReferenceOf(const EmergencyRequest& request);

// The request in a flight's wind.
EmergencyRequest InWind(EmergencyRequest request, const WindOfNow& wind);

// `object` holds the query parameters or the keys of the body. Throws ApiError.
EmergencyRequest ParseEmergencyRequest(const nlohmann::json& object);

}  // namespace freelsd
