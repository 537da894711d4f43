// Waypoints of Mission Planner and MAVLink: index current frame command p1 p2 p3 p4 x y z continue.
// The first one is home.
#include <array>
#include <cmath>

#include "api/import/number_text.h"
#include "api/import/routes/routes.h"
#include "api/import/utf8.h"
#include "api/json_reader.h"

namespace freelsd {
namespace {

constexpr std::string_view kBegin = "QGC WPL";
constexpr size_t kNumColumns = 12;
// MAVLink: MAV_CMD_DO_CHANGE_SPEED.
constexpr int kSpeedCommand = 178;

std::array<double, kNumColumns> NumbersIn(std::string_view line, int number) {
  std::array<double, kNumColumns> numbers{};
  size_t num = 0;
  while (!Trimmed(line).empty()) {
    line.remove_prefix(line.find_first_not_of(" \t\r"));
    const size_t end = std::min(line.find_first_of(" \t\r"), line.size());
    const std::optional<double> value = NumberFromText(line.substr(0, end));
    if (!value || num == kNumColumns) {
      num = kNumColumns + 1;
      break;
    }
    numbers.at(num++) = *value;
    line.remove_prefix(end);
  }
  if (num == kNumColumns) return numbers;
  throw InvalidValue("line " + std::to_string(number),
                     "line " + std::to_string(number) + ": a waypoint must have 12 numbers");
}

// A whole number that fits, else -1, which no command and no frame is.
int64_t WholeOf(double number) {
  constexpr double kMaxWhole = 1e6;
  return number >= 0.0 && number <= kMaxWhole ? std::llround(number) : -1;
}

}  // namespace

bool IsWaypoints(std::string_view text) {
  constexpr size_t kMaxHeadBytes = 200;
  return Trimmed(ToUtf8(text.substr(0, kMaxHeadBytes))).starts_with(kBegin);
}

nlohmann::json PlanOfWaypoints(std::string_view bytes) {
  const std::string text = ToUtf8(bytes);
  std::string_view rest = text;
  nlohmann::json items = nlohmann::json::array();
  nlohmann::json home;
  nlohmann::json cruise_speed_mps;
  for (int number = 1; !rest.empty(); ++number) {
    const size_t end = std::min(rest.find('\n'), rest.size());
    const std::string_view line = Trimmed(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (line.empty() || line[0] == '#' || line.starts_with(kBegin)) continue;
    const std::array<double, kNumColumns> n = NumbersIn(line, number);
    if (home.is_null()) {
      // Zeros: the home was not set.
      const bool is_set = n[8] != 0.0 || n[9] != 0.0;
      home = {n[8], n[9], is_set ? nlohmann::json(n[10]) : nlohmann::json()};
      continue;
    }
    const bool is_airspeed = WholeOf(n[3]) == kSpeedCommand && n[4] == 0.0 && n[5] > 0.0;
    if (is_airspeed && cruise_speed_mps.is_null()) {
      cruise_speed_mps = n[5];
      continue;
    }
    items.push_back({{"type", "SimpleItem"},
                     {"frame", WholeOf(n[2])},
                     {"command", WholeOf(n[3])},
                     {"params", {n[4], n[5], n[6], n[7], n[8], n[9], n[10]}}});
  }
  if (home.is_null()) throw InvalidValue("line 2", "the file has no waypoints");
  return {{"fileType", "Plan"},
          {"mission",
           {{"plannedHomePosition", home}, {"cruiseSpeed", cruise_speed_mps}, {"items", items}}}};
}

nlohmann::json ReadRouteFile(const std::string& bytes) {
  if (IsWaypoints(bytes)) return PlanOfWaypoints(bytes);
  return ParseJson(ToUtf8(bytes), kLimits.routes.max_bytes);
}

}  // namespace freelsd
