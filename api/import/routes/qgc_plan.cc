#include "api/import/routes/qgc_plan.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "api/json_reader.h"

namespace freelsd {
namespace {

// MAVLink commands (common.xml).
constexpr int kWaypoint = 16;
constexpr int kReturnToLaunch = 20;
constexpr int kLand = 21;
constexpr int kTakeOff = 22;
constexpr int kVtolTakeOff = 84;
constexpr int kVtolLand = 85;
constexpr int kChangeSpeed = 178;
constexpr int kJump = 177;
constexpr int kLandStart = 189;
// Loitering without end, for turns, for a time, to an altitude; a spline.
constexpr std::array kOtherPlaces{17, 18, 19, 31, 82};

// MAV_FRAME: global, above home, and both with integers.
constexpr std::array kAboveSeaFrames{0, 5};
constexpr std::array kAboveHomeFrames{3, 6};

template <size_t kSize>
bool Contains(const std::array<int, kSize>& values, int64_t value) {
  return std::find(values.begin(), values.end(), value) != values.end();
}

GeoPoint ReadCoordinate(const nlohmann::json& value, const std::string& pointer) {
  const std::vector<double> numbers = ReadNumbers(value, pointer, 3);
  return ReadGeoPoint(
      {{"latitude_deg", numbers[0]}, {"longitude_deg", numbers[1]}, {"altitude_m", numbers[2]}},
      pointer);
}

const nlohmann::json& Member(const nlohmann::json& object,
                             const std::string& key,
                             const std::string& pointer) {
  if (!object.is_object()) throw InvalidValue(pointer, "must be an object");
  const auto found = object.find(key);
  if (found == object.end()) throw InvalidValue(pointer + "/" + key, "is missing");
  return *found;
}

// Its altitude may be missing.
GeoPoint ReadHome(nlohmann::json value, const std::string& pointer) {
  const bool is_place = value.is_array() && (value.size() == 2 || value.size() == 3);
  const bool has_altitude = is_place && value.size() == 3 && !value[2].is_null();
  if (is_place && value[0].is_null()) throw InvalidValue(pointer, "the plan has no home");
  if (is_place && !has_altitude) value[2] = 0.0;
  GeoPoint home = ReadCoordinate(value, pointer);
  if (!has_altitude) home.altitude_m = std::nan("");
  return home;
}

const nlohmann::json& Items(const nlohmann::json& object, const std::string& pointer) {
  const nlohmann::json& items = Member(object, "items", pointer);
  if (!items.is_array()) throw InvalidValue(pointer + "/items", "must be an array");
  return items;
}

class MissionReader {
 public:
  // The home's altitude is NaN if it is not known.
  MissionReader(const GeoPoint& home, const std::string& home_pointer, PlannedRoute& route)
      : home_(home), home_pointer_(home_pointer), route_(route) {}

  void Read(const nlohmann::json& items, const std::string& pointer) {
    for (size_t i = 0; i < items.size() && !is_landing_; ++i) {
      item_ = "item " + std::to_string(i + 1);
      ReadItem(items[i], pointer + "/" + std::to_string(i));
    }
  }

 private:
  void ReadItem(const nlohmann::json& item, const std::string& pointer) {
    const std::string type = ReadString(Member(item, "type", pointer), pointer + "/type");
    if (type == "SimpleItem") return ReadSimple(item, pointer);
    if (type != "ComplexItem") throw InvalidValue(pointer + "/type", "is unknown");
    const std::string kind =
        ReadString(Member(item, "complexItemType", pointer), pointer + "/complexItemType");
    if (kind == "fwLandingPattern" || kind == "vtolLandingPattern") {
      return ReadPattern(item, pointer);
    }
    const auto transects = item.find("TransectStyleComplexItem");
    if (transects == item.end()) {
      return Warn(item_ + " (" + kind + ") is left out: it is no survey or landing pattern");
    }
    const std::string inside = pointer + "/TransectStyleComplexItem";
    const nlohmann::json& items = Member(*transects, "Items", inside);
    if (!items.is_array()) throw InvalidValue(inside + "/Items", "must be an array");
    if (items.empty()) Warn(item_ + " (" + kind + ") is left out: the plan has no places of it");
    for (size_t i = 0; i < items.size(); ++i) {
      ReadSimple(items[i], inside + "/Items/" + std::to_string(i));
    }
  }

  // The route ends on the circle before the final.
  void ReadPattern(const nlohmann::json& item, const std::string& pointer) {
    const std::string key = "landingApproachCoordinate";
    GeoPoint place = ReadCoordinate(Member(item, key, pointer), pointer + "/" + key);
    const auto relative = item.find("altitudesAreRelative");
    if (relative != item.end() && ReadBoolean(*relative, pointer + "/altitudesAreRelative")) {
      place.altitude_m += HomeAltitudeM();
    }
    route_.points.push_back(place);
    is_landing_ = true;
  }

  void ReadSimple(const nlohmann::json& item, const std::string& pointer) {
    const int64_t command = ReadInteger(Member(item, "command", pointer), pointer + "/command");
    const bool is_take_off = command == kTakeOff || command == kVtolTakeOff;
    if (command == kReturnToLaunch) return Return();
    if (command == kLand || command == kVtolLand || command == kLandStart) {
      is_landing_ = true;
      return;
    }
    if (command == kChangeSpeed) return Warn("changes of speed within the plan are left out");
    if (command == kJump) return Warn("jumps within the plan are left out");
    if (command != kWaypoint && !is_take_off && !Contains(kOtherPlaces, command)) return;
    if (is_take_off && route_.points.empty()) {
      route_.points.push_back({home_.latitude_deg, home_.longitude_deg, HomeAltitudeM()});
    }
    if (Contains(kOtherPlaces, command)) Warn("circles and curves of the plan are left out");
    AddPlace(item, pointer);
  }

  // Without latitude and longitude, a take-off is flown where the vehicle is.
  void AddPlace(const nlohmann::json& item, const std::string& pointer) {
    const nlohmann::json& params = Member(item, "params", pointer);
    if (!params.is_array() || params.size() != 7) {
      throw InvalidValue(pointer + "/params", "must be an array of 7");
    }
    const bool has_place =
        params[4].is_number() && params[5].is_number() && (params[4] != 0.0 || params[5] != 0.0);
    if (!has_place) {
      if (item["command"] == kWaypoint) Warn(item_ + " is left out: it has no place");
      return;
    }
    GeoPoint place = ReadCoordinate({params[4], params[5], params[6]}, pointer + "/params");
    const int64_t frame = ReadInteger(Member(item, "frame", pointer), pointer + "/frame");
    const auto above_sea = item.find("AMSLAltAboveTerrain");
    if (Contains(kAboveHomeFrames, frame)) {
      place.altitude_m += HomeAltitudeM();
    } else if (!Contains(kAboveSeaFrames, frame)) {
      // QGroundControl keeps what its own terrain made of the height.
      if (above_sea == item.end() || !above_sea->is_number()) {
        throw InvalidValue(pointer + "/frame",
                           item_ +
                               ": must be 0 (above mean sea level) or 3 (above home); heights "
                               "above terrain are unknown here");
      }
      place.altitude_m =
          ReadNumber(*above_sea, pointer + "/AMSLAltAboveTerrain", {-1000.0, 20000.0});
    }
    route_.points.push_back(place);
  }

  double HomeAltitudeM() const {
    if (!std::isnan(home_.altitude_m)) return home_.altitude_m;
    throw InvalidValue(home_pointer_,
                       "the plan's home has no altitude: that of " + item_ +
                           " counts from it; set the planned home position");
  }

  void Return() {
    if (route_.points.empty()) return;
    GeoPoint above_home = home_;
    above_home.altitude_m = route_.points.back().altitude_m;
    route_.points.push_back(above_home);
    is_landing_ = true;
  }

  void Warn(const std::string& warning) {
    std::vector<std::string>& warnings = route_.warnings;
    if (std::find(warnings.begin(), warnings.end(), warning) == warnings.end()) {
      warnings.push_back(warning);
    }
  }

  GeoPoint home_;
  std::string home_pointer_;
  PlannedRoute& route_;
  // As people count them.
  std::string item_;
  bool is_landing_ = false;
};

}  // namespace

PlannedRoute ReadQgcPlan(const nlohmann::json& plan, const std::string& pointer) {
  const std::string at = pointer + "/mission";
  const nlohmann::json& mission = Member(plan, "mission", pointer);
  const nlohmann::json& items = Items(mission, at);
  const std::string home_pointer = at + "/plannedHomePosition";
  const GeoPoint home = ReadHome(Member(mission, "plannedHomePosition", at), home_pointer);
  PlannedRoute route;
  const auto speed = mission.find("cruiseSpeed");
  if (speed != mission.end() && !speed->is_null()) {
    route.cruise_airspeed_mps = ReadNumber(*speed, at + "/cruiseSpeed", {1.0, 200.0});
  }
  MissionReader(home, home_pointer, route).Read(items, at + "/items");
  if (route.points.size() < 2) throw InvalidValue(at + "/items", "has fewer than two waypoints");
  return route;
}

}  // namespace freelsd
