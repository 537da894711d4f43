// Reads and changes a flight's row within the caller's transaction.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "storage/flight_store.h"
#include "storage/postgres/connection.h"

namespace freelsd {

// The columns of a flight, and the row that they give.
extern const char* const kFlightColumns;
FlightRow FlightRowOf(const PostgresRow& row);
// Other writers of the flight's row, frames and telemetry wait until the transaction ends. False if
// there is no such flight.
bool LockFlight(PostgresConnection& writer, const std::string& flight_id);
// The same for those of the flights that exist and that no other transaction has locked.
std::vector<std::string> LockFreeFlights(PostgresConnection& writer,
                                         const std::vector<std::string>& flight_ids);
// Locks the row. False if there is no such flight.
bool ChangeFlight(PostgresConnection& writer,
                  const std::string& flight_id,
                  const FlightChange& change);
// Those that the flight's frames name.
std::vector<std::string> ImagesOfFrames(PostgresConnection& writer, const std::string& flight_id);
// The same; nothing if there is no such flight.
std::optional<std::vector<std::string>> DeleteFlightRow(PostgresConnection& writer,
                                                        const std::string& flight_id);
// Least allowed arrived_at_us of the next row or frame of each locked flight.
std::map<std::string, int64_t> NextArrivalsOf(PostgresConnection& writer,
                                              const std::vector<std::string>& flight_ids);

}  // namespace freelsd
