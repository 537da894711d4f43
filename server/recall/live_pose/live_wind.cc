#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "engine/glide/glide.h"
#include "server/recall/live_pose/live_pose.h"

namespace freelsd {
namespace {

// Decision 0045: deviation of the change of a wind in each axis after a minute. It grows with the
// cube root of the time, as turbulence does.
constexpr double kChangeInMinuteMps = 0.33;
// Mean speed of the winds that it was measured in: gusts are stronger in a stronger wind.
constexpr double kMeasuredSpeedMps = 2.9;
// An answer holds at least so long, because its wind is not looked up more often.
constexpr double kMinHoldS = 5.0;

// Deviation in each axis of what the wind has changed since.
double ChangeMps(double speed_mps, double age_s) {
  return kChangeInMinuteMps * std::max(1.0, speed_mps / kMeasuredSpeedMps) *
         std::cbrt(age_s / 60.0);
}

std::string AgeText(double age_s) {
  const auto text = [age_s](double unit_s, const char* unit) {
    return std::to_string(std::lround(std::floor(age_s / unit_s))) + " " + unit;
  };
  if (age_s >= 2.0 * 86400.0) return text(86400.0, "days");
  return age_s >= 2.0 * 3600.0 ? text(3600.0, "hours") : text(60.0, "minutes");
}

// A wind that is too old to be one.
WindOfNow Unknown(const std::optional<double>& age_s) {
  WindOfNow now;
  now.warning = age_s ? "the last wind was measured " + AgeText(*age_s) +
                            " ago: after 3 hours the wind is unknown"
                      : "the age of the last wind is unknown, and so is the wind";
  return now;
}

}  // namespace

WindOfNow WindOfNowOf(const LiveWind& wind) {
  if (!wind.age_s || *wind.age_s > kMaxWindAgeS) return Unknown(wind.age_s);
  WindOfNow now;
  now.wind_in_world = wind.wind_in_world;
  now.sd_mps =
      std::hypot(wind.sd_mps.value_or(0.0), ChangeMps(wind.wind_in_world.norm(), *wind.age_s));
  now.is_old = *wind.age_s > kOldWindAgeS;
  const double limit_s = now.is_old ? kMaxWindAgeS : kOldWindAgeS;
  now.holds_for_s = std::min(std::max(kMinHoldS, 0.5 * *wind.age_s), limit_s - *wind.age_s);
  if (!now.is_old) return now;
  const double num_deviations = GlideOptions{}.num_wind_deviations;
  now.sd_mps = std::max(now.sd_mps, kOldWindChangeMps / num_deviations);
  now.warning = "the wind was measured " + AgeText(*wind.age_s) + " ago: it may have changed by " +
                std::to_string(std::lround(std::ceil(num_deviations * now.sd_mps))) +
                " m/s and turned by 45 degrees, and nothing is landable without a fresh one";
  return now;
}

nlohmann::json WindJson(const LiveWind& wind) {
  nlohmann::json object{{"east_mps", wind.wind_in_world.x()},
                        {"north_mps", wind.wind_in_world.y()},
                        {"age_s", nullptr}};
  if (wind.source) object["source"] = *wind.source;
  if (wind.sd_mps) object["sd_mps"] = *wind.sd_mps;
  if (wind.timestamp_us) object["timestamp_us"] = *wind.timestamp_us;
  if (wind.age_s) object["age_s"] = *wind.age_s;
  const WindOfNow now = WindOfNowOf(wind);
  object["counts_as"] = !now.wind_in_world ? "unknown" : now.is_old ? "old" : "known";
  if (now.wind_in_world) object["sd_now_mps"] = now.sd_mps;
  return object;
}

}  // namespace freelsd
