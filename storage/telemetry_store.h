// Telemetry of a flight: position, attitude and wind that the aircraft reports between frames.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace freelsd {

struct StorageState;

enum class TelemetryKind { kPosition, kAttitude, kWind };

// Values by kind. Position: latitude, longitude (deg), altitude (m). Attitude: quaternion
// ned_from_body w, x, y, z. Wind: east, north (m/s), the direction in which the air moves.
struct TelemetryRow {
  TelemetryKind kind = TelemetryKind::kPosition;
  int64_t timestamp_us = 0;
  std::array<double, 4> values{};
};

// The last row at or before a time, and the first row at or after it.
struct TelemetryPair {
  std::optional<TelemetryRow> before, after;
};

// Invariant: a flight has at most one row of a kind with the same timestamp.
class TelemetryStore {
 public:
  explicit TelemetryStore(StorageState& state) : state_(state) {}
  TelemetryStore(const TelemetryStore&) = delete;
  TelemetryStore& operator=(const TelemetryStore&) = delete;

  // Writes all rows in one commit. A row replaces the row of the same kind and timestamp. False,
  // and writes nothing, if there is no such flight.
  bool Put(const std::string& flight_id, const std::vector<TelemetryRow>& rows);
  TelemetryPair Around(const std::string& flight_id,
                       TelemetryKind kind,
                       int64_t timestamp_us) const;

 private:
  StorageState& state_;
};

}  // namespace freelsd
