// Completes an emergency request with the data of a flight.
#pragma once

#include <nlohmann/json.hpp>

#include "server/recall/emergency_request.h"
#include "storage/storage.h"

namespace freelsd {

// The request, completed with datum, wind, aircraft and heading. The heading is the direction of
// travel over ground, never the yaw of the attitude. It is taken only if the request's place is
// near the flight's latest position, because the aircraft may have turned since.
struct CompletedRequest {
  EmergencyRequest request;
  // The values that were taken from the flight: {flight_id, altitude_datum?, wind?, heading_deg?,
  // aircraft?, timestamp_us?}.
  nlohmann::json taken;
};

// request.flight_id must be set. Throws ApiError NoSuchFlight.
CompletedRequest CompletedFromFlight(const Storage& storage, const EmergencyRequest& request);

}  // namespace freelsd
