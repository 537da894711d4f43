// The datum of a flight's altitudes: the client's, else the one that the flight's own input tells.
#pragma once

#include <optional>
#include <string>

#include "api/api.h"
#include "storage/storage.h"

namespace freelsd {

// "amsl", "ellipsoid" or "unknown"; nothing if neither the client nor a settled frame has told it.
std::optional<std::string> ToldDatumOf(const FlightRow& flight);
// The same; "unknown" for nothing.
std::string AltitudeDatumOf(const FlightRow& flight);

// The datum told by all positions so far and by this one. A position that tells none is not of the
// others' datum: the answer is "unknown" then, as for two that differ.
std::string CommonDatum(const std::optional<std::string>& so_far, const FrameMeta& meta);
// The flight after a frame with this position was settled. A contradiction becomes a warning.
FlightRow WithDatumOf(FlightRow flight, const FrameMeta& meta);

}  // namespace freelsd
