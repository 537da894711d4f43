// The flight's row, for those who change it within a transaction of their own.
#pragma once

#include <string>

#include "storage/sqlite.h"
#include "storage/storage.h"

namespace freelsd {

// False where there is no such flight.
bool ChangeFlightRow(const Connection& writer,
                     const std::string& flight_id,
                     const Storage::FlightChange& change);

// Within a transaction of the caller.
void InsertJobRow(const Connection& writer, const JobRow& job);

}  // namespace freelsd
