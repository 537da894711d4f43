// The latest position, course and wind of a flight's aircraft, from telemetry and frames. The
// latest sample of telemetry is the youngest one by its own time (FlightClock), because a link
// delivers old samples after an outage. A sample whose time is ahead of the clocks counts last. Of
// frames it is the one that arrived last: cameras' clocks are often wrong. The age of a frame
// counts from its arrival, of one of a batch from its own time. A wind changes, the faster the
// stronger it is (decision 0045): every answer about now takes a flight's wind from here.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "engine/flight/flight.h"
#include "storage/storage.h"

namespace freelsd {

struct LiveWind {
  // East and north, m/s: the direction in which the air moves.
  Eigen::Vector2d wind_in_world = Eigen::Vector2d::Zero();
  // The sample's own time, as the aircraft gave it.
  std::optional<int64_t> timestamp_us;
  // Since it was measured; nothing: unknown.
  std::optional<double> age_s;
  // "autopilot": its own estimate. "drift": from ground velocity, heading and airspeed. "frame":
  // sent with an image. Nothing: the sender did not say.
  std::optional<std::string> source;
  // Standard deviation in each axis when it was measured; nothing: unknown.
  std::optional<double> sd_mps;
};

// A wind of unknown age, or older than 3 hours, is no wind.
constexpr double kOldWindAgeS = 600.0;
constexpr double kMaxWindAgeS = 3.0 * 3600.0;
// So far an old wind may have changed and turned, at least.
constexpr double kOldWindChangeMps = 3.0;
constexpr double kOldWindTurnDeg = 45.0;

struct WindOfNow {
  // Nothing: unknown.
  std::optional<Eigen::Vector2d> wind_in_world;
  // Standard deviation in each axis, by measurement and age.
  double sd_mps = 0.0;
  // It still chooses the heading, but nothing is landable in it.
  bool is_old = false;
  // Of its age, for the answer.
  std::optional<std::string> warning;
  // So long the wind is worth about as much; nothing: for ever.
  std::optional<double> holds_for_s;
};

WindOfNow WindOfNowOf(const LiveWind& wind);

// {east_mps, north_mps, source?, sd_mps?, timestamp_us?, age_s, counts_as, sd_now_mps?}
nlohmann::json WindJson(const LiveWind& wind);

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
