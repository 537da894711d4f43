// What is known of a frame, from all that says something of it.
#pragma once

#include <string>

#include "api/api.h"
#include "server/service.h"

namespace freelsd {

// Sent with it over telemetry over the image's own tags.
FrameMeta KnownMeta(const Service& service,
                    const std::string& flight_id,
                    const FrameMeta& given,
                    const FrameMeta& tags);

enum class Resolution { kReady, kWaiting, kRejected };

// Settles what the engine takes of a queued frame, and the flight's rig with the first that has a
// position; both are stored, so that a replay takes the same. A frame without position waits for
// telemetry as long as it may, then it is rejected.
Resolution ResolveFrame(Service& service, const FlightRow& flight, FrameRow& frame, bool may_wait);

// Throws ApiError Conflict for a flight whose images were removed.
void RefuseWhenRetired(const FlightRow& flight);

}  // namespace freelsd
