// The latest position, course and wind of a flight's aircraft, from telemetry and frames. The
// latest sample of telemetry is the youngest one by its own time (FlightClock), because a link
// delivers old samples after an outage. A sample whose time is ahead of the clocks counts last. Of
// frames it is the one that arrived last: cameras' clocks are often wrong. The age of a frame
// counts from its arrival, of one of a batch from its own time.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "engine/flight/flight.h"
#include "server/recall/live_wind/live_wind.h"
#include "storage/storage.h"

namespace freelsd {

struct LivePose {
  GeoPoint place;
  // Datum of the position's altitude; nothing if the position was sent without a datum.
  std::optional<std::string> altitude_datum;
  // The position's own time, as the aircraft gave it.
  std::optional<int64_t> timestamp_us;
  // Since the aircraft was there; nothing: unknown.
  std::optional<double> age_s;
  // Direction of travel over ground, computed from the last positions. Nothing if they do not
  // determine it. Trap: the attitude does not give it, because in wind the aircraft does not fly
  // where its nose points.
  std::optional<double> heading_deg;
  std::optional<LiveWind> wind;
};

// An older course counts as unknown, because the aircraft may have turned since the position
// arrived.
constexpr double kMaxCourseAgeS = 3.0;

// Nothing if no position is known. `now_us`: result of ArrivalNowUs.
std::optional<LivePose> LivePoseOf(const Storage& storage,
                                   const std::string& flight_id,
                                   int64_t now_us);

// The flight's wind. One from drift counts only where no other is known, or none that is recent.
std::optional<LiveWind> LiveWindOf(const Storage& storage,
                                   const std::string& flight_id,
                                   int64_t now_us);

}  // namespace freelsd
