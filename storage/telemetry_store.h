// Telemetry of a flight: position, attitude and wind that the aircraft reports between frames.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace freelsd {

enum class TelemetryKind { kPosition, kAttitude, kWind };

// Values by kind. Position: latitude, longitude (deg), altitude (m), and the altitude's datum: 0
// not given, 1 amsl, 2 ellipsoid. Attitude: quaternion ned_from_body w, x, y, z. Wind: east, north
// (m/s), the direction in which the air moves; its standard deviation (m/s, 0 unknown), and its
// source: 0 not given, 1 autopilot, 2 drift.
struct TelemetryRow {
  TelemetryKind kind = TelemetryKind::kPosition;
  int64_t timestamp_us = 0;
  std::array<double, 4> values{};
  // When the server received the row, microseconds since 1970.
  int64_t arrived_at_us = 0;
};

// The last row at or before a time, and the first row at or after that time.
struct TelemetryPair {
  std::optional<TelemetryRow> before, after;
};

// Invariant: a flight has at most one row of a kind with the same timestamp.
class TelemetryStore {
 public:
  virtual ~TelemetryStore() = default;
  TelemetryStore(const TelemetryStore&) = delete;
  TelemetryStore& operator=(const TelemetryStore&) = delete;

  // Writes all rows in one commit, with those that other threads give at the same time. A row
  // replaces the row of the same kind and timestamp. If necessary, increases arrived_at_us: it must
  // exceed arrived_at_us of all stored rows and frames of the flight. The order of arrival is
  // therefore correct even if the clock was set back. If there is no such flight, writes nothing
  // and returns false.
  virtual bool Put(const std::string& flight_id, const std::vector<TelemetryRow>& rows) = 0;
  // Of a kind: the max_num_rows that arrived last, and from there back max_num_rows that arrived at
  // least a second apart: a link may deliver many old rows at once. In the order of arrival.
  virtual std::vector<TelemetryRow> Recent(const std::string& flight_id,
                                           TelemetryKind kind,
                                           int max_num_rows) const = 0;
  virtual TelemetryPair Around(const std::string& flight_id,
                               TelemetryKind kind,
                               int64_t timestamp_us) const = 0;

 protected:
  TelemetryStore() = default;
};

}  // namespace freelsd
