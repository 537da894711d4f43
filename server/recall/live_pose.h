// What a flight's telemetry and frames say about its aircraft now. The order is that of arrival:
// the aircraft's clock may be wrong or unset.
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
  // As told with the position; nothing: not told.
  std::optional<std::string> altitude_datum;
  // The position's own time, as the aircraft gave it.
  std::optional<int64_t> timestamp_us;
  // Since the server received it; nothing: unknown.
  std::optional<double> age_s;
  // Direction of travel over ground, while the last positions tell it. Never from an attitude:
  // where the nose points is not where the aircraft goes.
  std::optional<double> heading_deg;
  std::optional<LiveWind> wind;
};

// A course is known for so long after the position arrived: it may have turned since.
constexpr double kMaxCourseAgeS = 3.0;

// Nothing if no position is known. `now_us`: of ArrivalNowUs.
std::optional<LivePose> LivePoseOf(const Storage& storage,
                                   const std::string& flight_id,
                                   int64_t now_us);

}  // namespace freelsd
