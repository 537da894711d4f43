// What a flight's own data tell about its aircraft, for an emergency request that does not say it.
#pragma once

#include <nlohmann/json.hpp>

#include "server/recall/emergency_request.h"
#include "storage/storage.h"

namespace freelsd {

// The request with what it leaves open: datum, wind, aircraft, and heading. The heading is the
// track over ground, never the attitude's yaw; it is taken only near the flight's latest position,
// because the track of another place is none.
struct CompletedRequest {
  EmergencyRequest request;
  // {flight_id, altitude_datum?, wind?, heading_deg?, aircraft?, timestamp_us?}: what was taken.
  nlohmann::json taken;
};

// `request` names a flight. Throws ApiError NoSuchFlight.
CompletedRequest CompletedFromFlight(const Storage& storage, const EmergencyRequest& request);

}  // namespace freelsd
