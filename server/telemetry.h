// Telemetry: what an aircraft says of itself between frames, and the pose at a frame's time.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/api.h"
#include "server/config.h"
#include "storage/storage.h"

namespace freelsd {

// One line of NDJSON: {timestamp_us, position?, attitude?, wind?}. Throws ApiError.
std::vector<TelemetryRow> ParseTelemetryLine(const std::string& line);

// Position, attitude and wind at that time, each where samples on both sides are at most
// max_telemetry_gap_s apart (positions and winds linearly, attitudes along the shortest turn), or
// where one is at most max_telemetry_extrapolation_s off: then it is taken as it is.
FrameMeta TelemetryAt(const Storage& storage,
                      const Config& config,
                      const std::string& flight_id,
                      int64_t timestamp_us);

// The latest of each kind.
FrameMeta LatestTelemetry(const Storage& storage, const std::string& flight_id);

}  // namespace freelsd
