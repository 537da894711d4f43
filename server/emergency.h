// Emergency recall: which stored sites an aircraft without power can reach. From storage alone.
#pragma once

#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "engine/glide/glide.h"
#include "server/service.h"

namespace freelsd {

// Largest `limit` of one request.
constexpr size_t kMaxNumEmergencySites = 50;

struct EmergencyRequest {
  GeoPoint place;
  std::string altitude_datum = "unknown";
  // Where the air moves to.
  std::optional<Eigen::Vector2d> wind_in_world;
  std::optional<double> heading_deg;
  std::optional<double> glide_ratio;
  // Nothing: each site's own.
  std::optional<Aircraft> aircraft;
  size_t limit = 5;
};

// Query parameters and keys of the body alike. Throws ApiError.
EmergencyRequest ParseEmergencyRequest(const nlohmann::json& object);

// {sites, nearest_miss?, warnings}.
nlohmann::json RecallSites(const Service& service, const EmergencyRequest& request);

}  // namespace freelsd
