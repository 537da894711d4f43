// The flight that a path names.
#pragma once

#include "server/call.h"
#include "server/service.h"

namespace freelsd {

// Throws ApiError NoSuchFlight.
FlightRow ExistingFlight(const Service& service, const Call& call);

}  // namespace freelsd
