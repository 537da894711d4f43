// Parses telemetry and interpolates the pose at a frame's timestamp.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/api.h"
#include "server/config.h"
#include "storage/storage.h"

namespace freelsd {

// Throws ApiError if the time is more than a day ahead of the server's clock. A clock before
// kFirstPlausibleUs was never set and refuses nothing; past times are always legitimate.
void RefuseFutureTime(int64_t timestamp_us, int64_t now_us);

// Parses one line of NDJSON: {timestamp_us, position?, attitude?, wind?}. Throws ApiError.
std::vector<TelemetryRow> ParseTelemetryLine(const std::string& line);

// Position, attitude and wind at `timestamp_us`. Each is interpolated between the samples before
// and after if these are at most max_telemetry_gap_s apart: positions and winds linearly, attitudes
// along the shortest rotation. Otherwise a sample at most max_telemetry_extrapolation_s away is
// used unchanged. Without such a sample the value is empty.
FrameMeta TelemetryAt(const Storage& storage,
                      const Config& config,
                      const std::string& flight_id,
                      int64_t timestamp_us);

// A wind that the aircraft measured between two frames.
struct MeasuredWind {
  int64_t timestamp_us = 0;
  GeoPoint place;
  // As in Frame.
  Eigen::Vector2d wind_in_world = Eigen::Vector2d::Zero();
};

// Winds measured after one time and before another, where telemetry gives a position too; oldest
// first. The latest ones if there are very many.
std::vector<MeasuredWind> WindsBetween(const Storage& storage,
                                       const Config& config,
                                       const std::string& flight_id,
                                       int64_t after_us,
                                       int64_t before_us);

// The datum of the altitude in a row of a position; nothing if it is not told.
std::optional<std::string> AltitudeDatumOf(const TelemetryRow& position);

}  // namespace freelsd
