// The order in which a flight's frames and telemetry arrived.
#pragma once

#include <cstdint>
#include <string>

#include "storage/sqlite/sqlite.h"

namespace freelsd {

// Least allowed arrived_at_us of the next row or frame. It is greater than that of every row and
// frame that the flight already has.
int64_t NextArrival(const Connection& connection, const std::string& flight_id);

}  // namespace freelsd
