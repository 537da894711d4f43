// The latest position, course and wind of a flight's aircraft, from telemetry and frames. "Latest"
// is by time of arrival, because the aircraft's clock may be wrong.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "engine/flight/flight.h"
#include "storage/storage.h"

namespace freelsd {

struct LiveWind {
  // East and north, m/s: the direction in which the air moves.
  Eigen::Vector2d wind_in_world = Eigen::Vector2d::Zero();
  // The sample's own time, as the aircraft gave it.
  std::optional<int64_t> timestamp_us;
  // Since the server received it; nothing: unknown.
  std::optional<double> age_s;
};

struct LivePose {
  GeoPoint place;
  // Datum of the position's altitude; nothing if the position was sent without a datum.
  std::optional<std::string> altitude_datum;
  // The position's own time, as the aircraft gave it.
  std::optional<int64_t> timestamp_us;
  // Since the server received it; nothing: unknown.
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

}  // namespace freelsd
