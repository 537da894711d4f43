// Changes a flight's row within the caller's transaction.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "storage/flight_store.h"
#include "storage/sqlite/sqlite.h"

namespace freelsd {

// False if there is no such flight.
bool ChangeFlightRow(const Connection& writer,
                     const std::string& flight_id,
                     const FlightChange& change);
// The image files that neither another flight nor a map needs; nothing if there is no such flight.
std::optional<std::vector<std::string>> DeleteFlightRow(const Connection& writer,
                                                        const std::string& flight_id);

}  // namespace freelsd
