// The order in which a flight's frames and telemetry arrived.
#pragma once

#include <cstdint>
#include <string>

#include "storage/sqlite/sqlite.h"

namespace freelsd {

// The least arrived_at_us of what arrives next: above all that the flight already has.
int64_t NextArrival(const Connection& connection, const std::string& flight_id);

}  // namespace freelsd
