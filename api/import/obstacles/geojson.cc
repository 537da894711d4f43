#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/import/date_time.h"
#include "api/import/import.h"
#include "api/import/obstacles/obstacles.h"
#include "api/import/obstacles/shape.h"
#include "api/import/utf8.h"
#include "api/json_reader.h"

namespace freelsd {
namespace {

constexpr std::pair<ObstacleKind, const char*> kKindNames[] = {
    {ObstacleKind::kWire, "wire"},
    {ObstacleKind::kMast, "mast"},
    {ObstacleKind::kNoFly, "no_fly"},
    {ObstacleKind::kPeople, "people"},
    {ObstacleKind::kWiresKnown, "wires_known"}};
constexpr NumberRange kAltitudeRange{-1000.0, 20000.0};
constexpr NumberRange kHeightRange{0.1, 1000.0};
constexpr NumberRange kAirspaceHeightRange{0.0, 20000.0};
constexpr NumberRange kSdRange{0.0, 500.0};
// Where it is not given: of a line or mast read from a good map, and of people.
constexpr double kDefaultSdM = 5.0;
constexpr double kDefaultPeopleSdM = 20.0;
// A degree of latitude.
constexpr double kMetresPerDegree = 111320.0;
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

constexpr int64_t kSecondUs = 1000000;

std::string TextOfTime(int64_t timestamp_us) {
  const std::time_t seconds = timestamp_us / kSecondUs;
  std::tm utc{};
  ::gmtime_r(&seconds, &utc);
  char text[40];
  std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

const char* NameOf(ObstacleKind kind) {
  for (const auto& [each, name] : kKindNames) {
    if (each == kind) return name;
  }
  return "";
}

ObstacleKind ReadKind(ObjectReader& properties) {
  const std::string text = ReadString(properties.Required("kind"), properties.PointerTo("kind"));
  for (const auto& [kind, name] : kKindNames) {
    if (text == name) return kind;
  }
  throw InvalidValue(properties.PointerTo("kind"),
                     "kind: must be wire, mast, no_fly, people or wires_known");
}

GeoPoint ReadPosition(const nlohmann::json& value, const std::string& pointer) {
  const std::vector<double> numbers = ReadNumbers(value, pointer, std::nullopt);
  if (numbers.size() < 2 || numbers.size() > 3) {
    throw InvalidValue(pointer, "a position must be [longitude, latitude] or with an altitude");
  }
  if (std::abs(numbers[0]) > 180.0) {
    throw InvalidValue(pointer + "/0", "longitude: must be in [-180, 180]");
  }
  if (std::abs(numbers[1]) > 90.0) {
    throw InvalidValue(pointer + "/1", "latitude: must be in [-90, 90]");
  }
  GeoPoint point{numbers[1], numbers[0], kUnknown};
  if (numbers.size() == 3) point.altitude_m = ReadNumber(value[2], pointer + "/2", kAltitudeRange);
  return point;
}

std::vector<GeoPoint> ReadPositions(const nlohmann::json& value,
                                    const std::string& pointer,
                                    size_t min_num) {
  if (!value.is_array() || value.size() < min_num) {
    throw InvalidValue(
        pointer, "coordinates: at least " + std::to_string(min_num) + " positions are needed");
  }
  if (value.size() > kLimits.obstacles.max_num_points) {
    ApiError error =
        InvalidValue(pointer,
                     "coordinates: at most " + std::to_string(kLimits.obstacles.max_num_points) +
                         " positions are allowed");
    error.limit = static_cast<double>(kLimits.obstacles.max_num_points);
    error.observed = static_cast<double>(value.size());
    throw error;
  }
  std::vector<GeoPoint> points;
  for (size_t i = 0; i < value.size(); ++i) {
    points.push_back(ReadPosition(value[i], pointer + "/" + std::to_string(i)));
  }
  return points;
}

std::vector<GeoPoint> ReadRing(const nlohmann::json& value, const std::string& pointer) {
  if (!value.is_array() || value.size() != 1) {
    throw InvalidValue(pointer,
                       "coordinates: a Polygon must have one ring, holes are not supported");
  }
  std::vector<GeoPoint> ring = ReadPositions(value[0], pointer + "/0", 4);
  const bool is_closed = ring.front().latitude_deg == ring.back().latitude_deg &&
                         ring.front().longitude_deg == ring.back().longitude_deg;
  if (!is_closed) {
    throw InvalidValue(pointer + "/0", "coordinates: the last position must equal the first");
  }
  ring.pop_back();
  return ring;
}

// Rough, and never too short by more than a share of a thousand.
double LegM(const GeoPoint& a, const GeoPoint& b) {
  const double middle_deg = 0.5 * (a.latitude_deg + b.latitude_deg);
  return kMetresPerDegree *
         std::hypot(b.latitude_deg - a.latitude_deg,
                    (b.longitude_deg - a.longitude_deg) * std::cos(RadFromDeg(middle_deg)));
}

void RefuseLongLegs(const GivenObstacle& obstacle, const std::string& pointer) {
  const std::vector<GeoPoint>& points = obstacle.points;
  const double max_leg_m = obstacle.kind == ObstacleKind::kNoFly
                               ? kLimits.obstacles.max_airspace_leg_m
                               : kLimits.obstacles.max_leg_m;
  const size_t num_legs = obstacle.is_area ? points.size() : points.size() - 1;
  for (size_t i = 0; i < num_legs; ++i) {
    const GeoPoint& next = points[(i + 1) % points.size()];
    const double leg_m = LegM(points[i], next);
    const bool is_around = std::abs(next.longitude_deg - points[i].longitude_deg) > 180.0;
    if (leg_m <= max_leg_m && !is_around) continue;
    ApiError error =
        InvalidValue(pointer,
                     "coordinates: positions " + std::to_string(i) + " and " +
                         std::to_string(i + 1) + " are " + std::to_string(std::lround(leg_m)) +
                         " m apart; at most " + std::to_string(std::lround(max_leg_m)) +
                         " m are allowed, and none crosses the antimeridian");
    error.limit = max_leg_m;
    error.observed = leg_m;
    throw error;
  }
}

void ReadGeometry(const nlohmann::json& value, const std::string& pointer, GivenObstacle& read) {
  ObjectReader reader(value, pointer);
  reader.RefuseKeysExcept({"type", "coordinates", "bbox"});
  const std::string type = ReadString(reader.Required("type"), reader.PointerTo("type"));
  const nlohmann::json& coordinates = reader.Required("coordinates");
  const std::string at = reader.PointerTo("coordinates");
  const ObstacleKind kind = read.kind;
  const bool is_point = kind == ObstacleKind::kMast || kind == ObstacleKind::kPeople;
  if (type == "Point" && is_point) {
    read.points = {ReadPosition(coordinates, at)};
  } else if (type == "LineString" && kind == ObstacleKind::kWire) {
    read.points = ReadPositions(coordinates, at, 2);
  } else if (type == "Polygon" && kind != ObstacleKind::kWire && kind != ObstacleKind::kMast) {
    read.points = ReadRing(coordinates, at);
    read.is_area = true;
  } else {
    const std::string wanted = kind == ObstacleKind::kWire     ? "LineString"
                               : kind == ObstacleKind::kMast   ? "Point"
                               : kind == ObstacleKind::kPeople ? "Point or Polygon"
                                                               : "Polygon";
    throw InvalidValue(
        reader.PointerTo("type"),
        "type: the geometry of " + std::string(NameOf(kind)) + " must be a " + wanted);
  }
  RefuseLongLegs(read, at);
}

// Refuses a property that has no meaning for the kind.
void RefuseFor(ObjectReader& properties, const char* key, bool is_meant, const char* for_whom) {
  if (is_meant || properties.Find(key) == nullptr) return;
  throw InvalidValue(properties.PointerTo(key), std::string(key) + ": is only for " + for_whom);
}

void ReadHeights(ObjectReader& properties, GivenObstacle& read) {
  const bool is_airspace = read.kind == ObstacleKind::kNoFly;
  RefuseFor(properties, "floor_m", is_airspace, "no_fly");
  RefuseFor(properties, "ceiling_m", is_airspace, "no_fly");
  RefuseFor(properties, "floor_above_ground_m", is_airspace, "no_fly");
  RefuseFor(properties, "ceiling_above_ground_m", is_airspace, "no_fly");
  const bool has_top = read.kind == ObstacleKind::kWire || read.kind == ObstacleKind::kMast;
  RefuseFor(properties, "height_m", has_top, "wire and mast");
  read.floor_m = properties.Number("floor_m", kAltitudeRange);
  read.ceiling_m = properties.Number("ceiling_m", kAltitudeRange);
  read.floor_above_ground_m = properties.Number("floor_above_ground_m", kAirspaceHeightRange);
  read.ceiling_above_ground_m = properties.Number("ceiling_above_ground_m", kAirspaceHeightRange);
  read.height_m = properties.Number("height_m", kHeightRange);
  const auto require_below = [&](const char* key, const auto& floor, const auto& ceiling) {
    if (!floor || !ceiling || *floor < *ceiling) return;
    throw InvalidValue(properties.PointerTo(key), std::string(key) + ": must be below its ceiling");
  };
  require_below("floor_m", read.floor_m, read.ceiling_m);
  require_below("floor_above_ground_m", read.floor_above_ground_m, read.ceiling_above_ground_m);
  if ((read.floor_m && read.floor_above_ground_m) ||
      (read.ceiling_m && read.ceiling_above_ground_m)) {
    throw InvalidValue(properties.PointerTo("floor_above_ground_m"),
                       "floor and ceiling: each is an altitude or a height above ground, not both");
  }
}

void ReadExpiry(ObjectReader& properties, GivenObstacle& read) {
  const std::string pointer = properties.PointerTo("expires_at");
  const nlohmann::json* const expires_at = properties.Find("expires_at");
  if (expires_at == nullptr) {
    if (read.kind != ObstacleKind::kPeople) return;
    throw InvalidValue(pointer, "expires_at: is needed for people");
  }
  const std::optional<int64_t> time_us = TimestampFromText(ReadString(*expires_at, pointer));
  if (!time_us || *time_us <= 0) {
    throw InvalidValue(pointer, "expires_at: must be a time as 2026-07-01T12:00:00Z");
  }
  // Answers have whole seconds; it never expires early.
  read.expires_at_us = (*time_us + kSecondUs - 1) / kSecondUs * kSecondUs;
}

void ReadProperties(ObjectReader& properties, GivenObstacle& read) {
  if (const nlohmann::json* const name = properties.Find("name")) {
    const std::string pointer = properties.PointerTo("name");
    read.name = ReadString(*name, pointer);
    if (read.name.size() > kLimits.max_name_bytes) {
      throw InvalidValue(
          pointer,
          "name: at most " + std::to_string(kLimits.max_name_bytes) + " bytes are allowed");
    }
  }
  if (const nlohmann::json* const datum = properties.Find("altitude_datum")) {
    const std::string pointer = properties.PointerTo("altitude_datum");
    read.altitude_datum = ReadString(*datum, pointer);
    if (read.altitude_datum != "amsl" && read.altitude_datum != "ellipsoid" &&
        read.altitude_datum != "unknown") {
      throw InvalidValue(pointer, "altitude_datum: must be amsl, ellipsoid or unknown");
    }
  }
  const bool is_people = read.kind == ObstacleKind::kPeople;
  read.position_sd_m = properties.Number("position_sd_m", kSdRange)
                           .value_or(is_people ? kDefaultPeopleSdM : kDefaultSdM);
  ReadHeights(properties, read);
  ReadExpiry(properties, read);
}

// A wire or mast needs a top.
void RequireTops(const GivenObstacle& read, const std::string& pointer) {
  const bool needs_top = read.kind == ObstacleKind::kWire || read.kind == ObstacleKind::kMast;
  if (!needs_top || read.height_m) return;
  for (const GeoPoint& point : read.points) {
    if (!std::isnan(point.altitude_m)) continue;
    throw InvalidValue(pointer + "/geometry/coordinates",
                       "coordinates: every position needs an altitude, or height_m is needed");
  }
}

std::string ReadId(const nlohmann::json& value, const std::string& pointer) {
  std::string id = ReadString(value, pointer);
  if (!IsValidId(id))
    throw ApiError(
        "InvalidId", "id: must match [A-Za-z0-9._-]{1,128}", {{pointer, "is not valid"}});
  return id;
}

nlohmann::json PositionOf(const GeoPoint& point) {
  nlohmann::json position{point.longitude_deg, point.latitude_deg};
  if (!std::isnan(point.altitude_m)) position.push_back(point.altitude_m);
  return position;
}

nlohmann::json GeometryOf(const GivenObstacle& obstacle) {
  if (obstacle.points.size() == 1) {
    return {{"type", "Point"}, {"coordinates", PositionOf(obstacle.points.front())}};
  }
  nlohmann::json positions = nlohmann::json::array();
  for (const GeoPoint& point : obstacle.points) positions.push_back(PositionOf(point));
  if (!obstacle.is_area) return {{"type", "LineString"}, {"coordinates", std::move(positions)}};
  positions.push_back(PositionOf(obstacle.points.front()));
  nlohmann::json rings = nlohmann::json::array();
  rings.push_back(std::move(positions));
  return {{"type", "Polygon"}, {"coordinates", std::move(rings)}};
}

GivenObstacle ReadFeature(const nlohmann::json& feature, const std::string& pointer) {
  ObjectReader reader(feature, pointer);
  reader.RefuseKeysExcept({"type", "id", "geometry", "properties", "bbox"});
  if (ReadString(reader.Required("type"), reader.PointerTo("type")) != "Feature") {
    throw InvalidValue(reader.PointerTo("type"), "type: must be Feature");
  }
  GivenObstacle read;
  if (const nlohmann::json* const id = reader.Find("id")) {
    read.id = ReadId(*id, reader.PointerTo("id"));
  }
  ObjectReader properties(reader.Required("properties"), reader.PointerTo("properties"));
  // Answers have updated_at, so that what is read can be written back.
  properties.RefuseKeysExcept({"kind",
                               "name",
                               "altitude_datum",
                               "position_sd_m",
                               "height_m",
                               "floor_m",
                               "ceiling_m",
                               "floor_above_ground_m",
                               "ceiling_above_ground_m",
                               "expires_at",
                               "updated_at"});
  read.kind = ReadKind(properties);
  ReadProperties(properties, read);
  ReadGeometry(reader.Required("geometry"), reader.PointerTo("geometry"), read);
  RequireTops(read, pointer);
  return read;
}

void RefuseMeaninglessShape(const GivenObstacle& read, const std::string& pointer) {
  const std::string at = pointer + "/geometry/coordinates";
  if (read.kind == ObstacleKind::kWire && IsOnePlace(read.points)) {
    throw InvalidValue(at, "coordinates: a wire needs two different places; one place is a mast");
  }
  if (!read.is_area) return;
  if (IsFlat(read.points)) {
    throw InvalidValue(at, "coordinates: three different positions not on one line are needed");
  }
  if (CrossesItself(read.points)) {
    throw InvalidValue(at, "coordinates: the ring crosses itself");
  }
}

}  // namespace

GivenObstacle ParseObstacle(const nlohmann::json& feature, const std::string& pointer) {
  GivenObstacle read = ReadFeature(feature, pointer);
  if (HasControlCharacter(read.name)) {
    throw InvalidValue(pointer + "/properties/name", "name: must have no control characters");
  }
  RefuseMeaninglessShape(read, pointer);
  return read;
}

GivenObstacle ParseStoredObstacle(const nlohmann::json& feature) {
  return ReadFeature(feature, "");
}

nlohmann::json ObstacleFeature(const GivenObstacle& obstacle) {
  nlohmann::json properties{{"kind", NameOf(obstacle.kind)},
                            {"altitude_datum", obstacle.altitude_datum},
                            {"position_sd_m", obstacle.position_sd_m}};
  if (!obstacle.name.empty()) properties["name"] = obstacle.name;
  if (obstacle.height_m) properties["height_m"] = *obstacle.height_m;
  if (obstacle.kind == ObstacleKind::kNoFly) {
    properties["floor_m"] = nullptr;
    properties["ceiling_m"] = nullptr;
  }
  if (obstacle.floor_m) properties["floor_m"] = *obstacle.floor_m;
  if (obstacle.ceiling_m) properties["ceiling_m"] = *obstacle.ceiling_m;
  if (obstacle.floor_above_ground_m) {
    properties["floor_above_ground_m"] = *obstacle.floor_above_ground_m;
  }
  if (obstacle.ceiling_above_ground_m) {
    properties["ceiling_above_ground_m"] = *obstacle.ceiling_above_ground_m;
  }
  if (obstacle.expires_at_us) properties["expires_at"] = TextOfTime(*obstacle.expires_at_us);
  nlohmann::json feature{
      {"type", "Feature"}, {"geometry", GeometryOf(obstacle)}, {"properties", properties}};
  if (!obstacle.id.empty()) feature["id"] = obstacle.id;
  return feature;
}

ImportedObstacles ParseObstacles(const std::string& text) {
  const nlohmann::json collection = ParseJson(ToUtf8(text), kLimits.obstacles.max_import_bytes);
  ObjectReader reader(collection, "");
  if (ReadString(reader.Required("type"), "/type") != "FeatureCollection") {
    throw InvalidValue("/type", "type: must be FeatureCollection");
  }
  const nlohmann::json& features = reader.Required("features");
  if (!features.is_array()) throw InvalidValue("/features", "features: must be an array");
  if (features.size() > kLimits.obstacles.max_num_stored) {
    throw InvalidValue(
        "/features",
        "features: at most " + std::to_string(kLimits.obstacles.max_num_stored) + " are allowed");
  }
  if (std::any_of(features.begin(), features.end(), IsOpenStreetMap)) {
    return ImportOpenStreetMap(collection);
  }
  ImportedObstacles imported;
  for (size_t i = 0; i < features.size(); ++i) {
    imported.obstacles.push_back(ParseObstacle(features[i], "/features/" + std::to_string(i)));
  }
  return imported;
}

}  // namespace freelsd
