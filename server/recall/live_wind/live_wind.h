// The latest wind of a flight, and what it is worth by now: a wind changes, the faster the stronger
// it is (decision 0045). Every answer about now takes a flight's wind from here.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

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

}  // namespace freelsd
