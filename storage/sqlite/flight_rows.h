// Changes a flight's row within the caller's transaction.
#pragma once

#include <string>

#include "storage/flight_store.h"
#include "storage/sqlite/sqlite.h"

namespace freelsd {

// False if there is no such flight.
bool ChangeFlightRow(const Connection& writer,
                     const std::string& flight_id,
                     const FlightChange& change);

}  // namespace freelsd
