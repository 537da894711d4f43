// The datum of a flight's altitudes: the datum that the client gave, else the common datum of the
// resolved frames.
#pragma once

#include <optional>
#include <string>

#include "api/api.h"
#include "storage/storage.h"

namespace freelsd {

// "amsl", "ellipsoid" or "unknown". Nothing if the client gave none and no frame is resolved yet.
std::optional<std::string> ToldDatumOf(const FlightRow& flight);
// Like ToldDatumOf, with "unknown" instead of nothing.
std::string AltitudeDatumOf(const FlightRow& flight);

// The common datum of the positions so far and of this position. `so_far` is empty before the first
// position. The result is "unknown" if two datums differ, or if a position has no datum.
std::string CommonDatum(const std::optional<std::string>& so_far, const FrameMeta& meta);
// The flight with the datum of a newly resolved frame. If datums contradict each other, a warning
// is added to the flight.
FlightRow WithDatumOf(FlightRow flight, const FrameMeta& meta);

}  // namespace freelsd
