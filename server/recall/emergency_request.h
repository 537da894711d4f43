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

namespace freelsd {

// State of the aircraft, and the largest number of sites in the answer.
struct EmergencyRequest {
  GeoPoint place;
  // "amsl", "ellipsoid" or "unknown"; empty: not given, so unknown unless the flight tells it.
  std::optional<std::string> altitude_datum;
  // The flight that measured the altitude. What is not given may be taken from it.
  std::optional<std::string> flight_id;
  // East and north, m/s: the direction in which the air moves. Empty: unknown.
  std::optional<Eigen::Vector2d> wind_in_world;
  std::optional<double> heading_deg;
  std::optional<double> glide_ratio;
  // Safety heights: above the stored terrain below the path, and above the start of the final.
  double terrain_clearance_m = GlideOptions{}.terrain_clearance_m;
  double arrival_height_m = 0.0;
  // Empty: for each site, the aircraft for which the site was planned.
  std::optional<Aircraft> aircraft;
  size_t limit = 5;
};

// The request's altitude, to compare it with stored ones. Refers to the request's texts.
AltitudeReference ReferenceOf(const EmergencyRequest& request);

// `object` holds the query parameters or the keys of the body. Throws ApiError.
EmergencyRequest ParseEmergencyRequest(const nlohmann::json& object);

}  // namespace freelsd
