// Parses telemetry and interpolates the pose at a frame's timestamp.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/api.h"
#include "server/config.h"
#include "storage/storage.h"

namespace freelsd {

// Throws ApiError if the time is more than a day ahead of the server's clock. Past times are always
// accepted. If the server's clock is before kFirstPlausibleUs, it was never set, and every time is
// accepted.
void RefuseFutureTime(int64_t timestamp_us, int64_t now_us);

// Parses one line of NDJSON: {timestamp_us, position?, attitude?, wind?}. The wind may have sd_mps
// and source ("autopilot" or "drift"). Throws ApiError.
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

// Winds measured after after_us and before before_us, oldest first. A wind without a position is
// left out. If there are very many, only the latest ones are returned.
std::vector<MeasuredWind> WindsBetween(const Storage& storage,
                                       const Config& config,
                                       const std::string& flight_id,
                                       int64_t after_us,
                                       int64_t before_us);

// Where a row of kind kWind is from, "autopilot" or "drift", and its standard deviation. Nothing if
// the wind was sent without it.
std::optional<std::string> WindSourceOf(const TelemetryRow& wind);
std::optional<double> WindSdMps(const TelemetryRow& wind);

// Datum of the altitude in a row of kind kPosition; nothing if the position was sent without a
// datum.
std::optional<std::string> AltitudeDatumOf(const TelemetryRow& position);

}  // namespace freelsd
