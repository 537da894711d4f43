#include "server/following/told_change.h"

#include <cmath>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/import/import.h"
#include "server/recall/recall.h"

namespace freelsd {
namespace {

constexpr std::pair<ChangeSubject, const char*> kSubjects[] = {
    {ChangeSubject::kSite, "site"},
    {ChangeSubject::kMap, "map"},
    {ChangeSubject::kObstacle, "obstacle"}};
constexpr std::pair<ChangeKind, const char*> kKinds[] = {{ChangeKind::kStored, "stored"},
                                                         {ChangeKind::kUpdated, "updated"},
                                                         {ChangeKind::kSuperseded, "superseded"},
                                                         {ChangeKind::kConfirmed, "confirmed"},
                                                         {ChangeKind::kRemoved, "removed"},
                                                         {ChangeKind::kExpired, "expired"}};
constexpr char kLeft[] = "left";

template <typename Value, size_t kSize>
const char* WordOf(const std::pair<Value, const char*> (&words)[kSize], Value value) {
  for (const auto& [each, word] : words) {
    if (each == value) return word;
  }
  return "";
}

template <typename Value, size_t kSize>
std::optional<Value> ValueOf(const std::pair<Value, const char*> (&words)[kSize],
                             const std::string& word) {
  for (const auto& [each, known] : words) {
    if (known == word) return each;
  }
  return std::nullopt;
}

[[noreturn]] void Refuse(const std::string& pointer, const std::string& why) {
  throw ApiError("InvalidValue", pointer + ": " + why, {{pointer, why}});
}

// One object of the body; each getter names the place of what is wrong.
class Fields {
 public:
  Fields(const nlohmann::json& object, std::string pointer)
      : object_(object), pointer_(std::move(pointer)) {
    if (!object.is_object()) Refuse(pointer_, "must be an object");
  }

  const nlohmann::json* Find(const char* key) const {
    const auto found = object_.find(key);
    return found == object_.end() || found->is_null() ? nullptr : &*found;
  }
  const nlohmann::json& At(const char* key) const {
    const nlohmann::json* found = Find(key);
    if (found == nullptr) Refuse(PointerTo(key), "is missing");
    return *found;
  }
  std::string Text(const char* key) const {
    if (!At(key).is_string()) Refuse(PointerTo(key), "must be a string");
    return At(key).get<std::string>();
  }
  std::string TextOr(const char* key, const std::string& otherwise) const {
    return Find(key) == nullptr ? otherwise : Text(key);
  }
  double Number(const char* key) const {
    if (!At(key).is_number()) Refuse(PointerTo(key), "must be a number");
    return At(key).get<double>();
  }
  int64_t Integer(const char* key) const {
    if (!At(key).is_number_integer()) Refuse(PointerTo(key), "must be a whole number");
    return At(key).get<int64_t>();
  }
  std::optional<int64_t> OptionalInteger(const char* key) const {
    return Find(key) == nullptr ? std::nullopt : std::optional(Integer(key));
  }
  bool Flag(const char* key) const {
    if (!At(key).is_boolean()) Refuse(PointerTo(key), "must be true or false");
    return At(key).get<bool>();
  }
  const nlohmann::json& Object(const char* key) const {
    if (!At(key).is_object()) Refuse(PointerTo(key), "must be an object");
    return At(key);
  }
  BoundingBox Box(const char* key) const {
    const nlohmann::json& sides = At(key);
    bool is_box = sides.is_array() && sides.size() == 4;
    for (const nlohmann::json& side : sides) is_box = is_box && side.is_number();
    if (!is_box) Refuse(PointerTo(key), "must be [west, south, east, north] in degrees");
    const BoundingBox box{sides[0], sides[1], sides[2], sides[3]};
    if (std::abs(box.west_deg) > 360.0 || std::abs(box.east_deg) > 540.0 ||
        !(box.south_deg >= -90.0 && box.south_deg <= box.north_deg && box.north_deg <= 90.0)) {
      Refuse(PointerTo(key), "must be [west, south, east, north] in degrees");
    }
    return box;
  }
  std::string PointerTo(const char* key) const { return pointer_ + "/" + key; }

 private:
  const nlohmann::json& object_;
  std::string pointer_;
};

// The nearest float that is no greater.
double FloatBelow(double value) {
  const auto nearest = static_cast<float>(value);
  return nearest <= value ? nearest : std::nextafter(nearest, -HUGE_VALF);
}

// SQLite keeps boxes of sites as floats, PostgreSQL as doubles: both tell the same.
BoundingBox RoundedOut(const BoundingBox& box) {
  return {FloatBelow(box.west_deg),
          FloatBelow(box.south_deg),
          -FloatBelow(-box.east_deg),
          -FloatBelow(-box.north_deg)};
}

nlohmann::json BoxJson(const BoundingBox& box) {
  return {box.west_deg, box.south_deg, box.east_deg, box.north_deg};
}

nlohmann::json StandingJson(const Standing& standing) {
  nlohmann::json json = nlohmann::json::object();
  if (standing.superseded_by) {
    json["superseded_by"] = *standing.superseded_by;
  }
  if (!standing.superseded_reason.empty() || standing.superseded_by) {
    const std::string what = standing.superseded_by ? "superseded_" : "doubted_";
    json[what + "by_map"] = standing.superseded_by_map;
    json[what + "at_us"] = standing.superseded_at_us;
    json[what + "reason"] = standing.superseded_reason;
    json[what + "detail"] = standing.superseded_detail;
  }
  if (standing.confirmed_at_us) json["confirmed_at_us"] = *standing.confirmed_at_us;
  return json;
}

void ReadCause(const Fields& fields, const std::string& what, Standing& standing) {
  standing.superseded_by_map = fields.TextOr((what + "by_map").c_str(), "");
  standing.superseded_at_us = fields.Integer((what + "at_us").c_str());
  standing.superseded_reason = fields.Text((what + "reason").c_str());
  standing.superseded_detail = fields.Text((what + "detail").c_str());
}

Standing ParseStanding(const Fields& fields) {
  Standing standing;
  if (fields.Find("superseded_by") != nullptr) {
    standing.superseded_by = fields.Text("superseded_by");
    ReadCause(fields, "superseded_", standing);
  } else if (fields.Find("doubted_by_map") != nullptr) {
    ReadCause(fields, "doubted_", standing);
  }
  standing.confirmed_at_us = fields.OptionalInteger("confirmed_at_us");
  return standing;
}

nlohmann::json RecallJson(const RecallData& data) {
  return {{"is_landable", data.is_landable},
          {"altitude_m", data.altitude_m},
          {"altitude_datum", data.altitude_datum},
          {"score", data.score},
          {"aircraft", nlohmann::json::parse(data.aircraft_json)}};
}

nlohmann::json SiteJson(const SiteRow& site) {
  nlohmann::json json{{"flight_id", site.flight_id},
                      {"region_id", site.region_id},
                      {"latitude_deg", site.latitude_deg},
                      {"longitude_deg", site.longitude_deg},
                      {"feature", nlohmann::json::parse(site.feature_json)},
                      {"replan", nlohmann::json::parse(site.replan_json)},
                      {"updated_at_us", site.updated_at_us},
                      {"seen_at_us", site.seen_at_us},
                      {"map_datum", site.map_datum},
                      {"standing", StandingJson(site)}};
  if (site.seen_until_us) json["seen_until_us"] = *site.seen_until_us;
  if (!site.map_id.empty()) json["map_id"] = site.map_id;
  if (!site.approach_json.empty()) json["approach"] = nlohmann::json::parse(site.approach_json);
  if (site.recall) json["recall"] = RecallJson(*site.recall);
  if (site.map_box) json["map_box"] = BoxJson(RoundedOut(*site.map_box));
  return json;
}

RecallData ParseRecall(const Fields& fields, const SiteRow& site) {
  const nlohmann::json feature = nlohmann::json::parse(site.feature_json);
  const std::string verdict =
      feature.value(nlohmann::json::json_pointer("/properties/verdict"), std::string());
  RecallData data;
  data.is_landable = fields.Flag("is_landable");
  if (verdict != (data.is_landable ? "landable" : "unverified")) {
    Refuse(fields.PointerTo("is_landable"), "differs from the feature's verdict " + verdict);
  }
  data.altitude_m = fields.Number("altitude_m");
  data.altitude_datum = fields.Text("altitude_datum");
  data.score = fields.Number("score");
  data.aircraft_json = fields.Object("aircraft").dump();
  ParseAircraft(fields.Object("aircraft"), fields.PointerTo("aircraft"));
  return data;
}

SiteRow ParseSite(const std::string& id, const Fields& fields) {
  SiteRow site;
  site.id = id;
  site.flight_id = fields.Text("flight_id");
  site.region_id = fields.Integer("region_id");
  site.map_id = fields.TextOr("map_id", "");
  site.latitude_deg = fields.Number("latitude_deg");
  site.longitude_deg = fields.Number("longitude_deg");
  site.feature_json = fields.Object("feature").dump();
  if (fields.Find("approach") != nullptr) site.approach_json = fields.Object("approach").dump();
  site.replan_json = fields.Object("replan").dump();
  site.updated_at_us = fields.Integer("updated_at_us");
  site.seen_at_us = fields.Integer("seen_at_us");
  site.seen_until_us = fields.OptionalInteger("seen_until_us");
  site.map_datum = fields.Text("map_datum");
  if (fields.Find("map_box") != nullptr) site.map_box = fields.Box("map_box");
  const Fields standing(fields.At("standing"), fields.PointerTo("standing"));
  static_cast<Standing&>(site) = ParseStanding(standing);
  if (const nlohmann::json* recall = fields.Find("recall")) {
    site.recall = ParseRecall({*recall, fields.PointerTo("recall")}, site);
    try {
      ParseReplan(site.replan_json);
    } catch (const std::exception& error) {
      Refuse(fields.PointerTo("replan"), error.what());
    }
  }
  if (std::abs(site.latitude_deg) > 90.0 || std::abs(site.longitude_deg) > 180.0) {
    Refuse(fields.PointerTo("latitude_deg"), "the touchdown is no place");
  }
  return site;
}

nlohmann::json MapJson(const FlightMapRow& map) {
  nlohmann::json json{{"flight_id", map.flight_id},
                      {"altitude_datum", map.altitude_datum},
                      {"box", BoxJson(map.box)},
                      {"updated_at_us", map.updated_at_us},
                      {"seen_at_us", map.seen_at_us},
                      {"bytes", "/v1/maps/" + map.id}};
  if (map.seen_until_us) json["seen_until_us"] = *map.seen_until_us;
  return json;
}

FlightMapRow ParseMap(const std::string& id, const Fields& fields) {
  FlightMapRow map;
  map.id = id;
  map.flight_id = fields.Text("flight_id");
  map.altitude_datum = fields.Text("altitude_datum");
  map.box = fields.Box("box");
  map.updated_at_us = fields.Integer("updated_at_us");
  map.seen_at_us = fields.Integer("seen_at_us");
  map.seen_until_us = fields.OptionalInteger("seen_until_us");
  return map;
}

nlohmann::json ObstacleJson(const ObstacleRow& obstacle) {
  nlohmann::json json{{"feature", nlohmann::json::parse(obstacle.feature_json)},
                      {"updated_at_us", obstacle.updated_at_us}};
  if (obstacle.expires_at_us) json["expires_at_us"] = *obstacle.expires_at_us;
  return json;
}

ObstacleRow ParseObstacleRow(const std::string& id, const Fields& fields) {
  ObstacleRow row;
  row.id = id;
  row.feature_json = fields.Object("feature").dump();
  row.updated_at_us = fields.Integer("updated_at_us");
  if (fields.Find("expires_at_us") != nullptr) row.expires_at_us = fields.Integer("expires_at_us");
  row.box = BoxOfPoints(ParseStoredObstacle(fields.Object("feature")).points);
  return row;
}

void ParseStored(const Fields& fields, ToldChange& told) {
  const std::string& id = told.change.key.id;
  switch (told.change.key.subject) {
    case ChangeSubject::kSite: {
      const Fields site(fields.At("site"), fields.PointerTo("site"));
      told.site = ParseSite(id, site);
      told.change.stamp_us = told.site->updated_at_us;
      break;
    }
    case ChangeSubject::kMap:
      told.map = ParseMap(id, {fields.At("map"), fields.PointerTo("map")});
      told.change.stamp_us = told.map->updated_at_us;
      break;
    case ChangeSubject::kObstacle:
      told.obstacle = ParseObstacleRow(id, {fields.At("obstacle"), fields.PointerTo("obstacle")});
      told.change.stamp_us = told.obstacle->updated_at_us;
      break;
  }
}

}  // namespace

std::optional<ChangeSubject> SubjectOfWord(const std::string& word) {
  return ValueOf(kSubjects, word);
}

std::optional<ToldChange> ReadTold(const Storage& storage, const ChangeRow& change) {
  ToldChange told;
  told.change = change;
  if (told.IsRemoval()) return told;
  switch (change.key.subject) {
    case ChangeSubject::kSite:
      told.site = storage.sites.FindWhole(change.key.id);
      break;
    case ChangeSubject::kMap:
      told.map = storage.maps.Find(change.key.id);
      break;
    case ChangeSubject::kObstacle:
      told.obstacle = storage.obstacles.Find(change.key.id);
      break;
  }
  // Obstacles are read from the second copy, which is written after the first one.
  if (told.obstacle && told.obstacle->updated_at_us < change.stamp_us) return std::nullopt;
  if (!told.site && !told.map && !told.obstacle) return std::nullopt;
  return told;
}

nlohmann::json ToldJson(const ToldChange& told, const std::string& feed) {
  const ChangeRow& change = told.change;
  nlohmann::json json{{"number", change.number},
                      {"subject", WordOf(kSubjects, change.key.subject)},
                      {"id", change.key.id},
                      {"change", told.has_left ? kLeft : WordOf(kKinds, change.kind)},
                      {"origin", change.origin.empty() ? feed : change.origin}};
  if (told.IsRemoval()) json["stamp_us"] = change.stamp_us;
  if (told.IsRemoval() || told.has_left) return json;
  if (told.site) json["site"] = SiteJson(*told.site);
  if (told.map) json["map"] = MapJson(*told.map);
  if (told.obstacle) json["obstacle"] = ObstacleJson(*told.obstacle);
  return json;
}

ToldChange ParseTold(const nlohmann::json& object, const std::string& pointer) {
  const Fields fields(object, pointer);
  ToldChange told;
  const std::string word = fields.Text("change");
  const auto subject = SubjectOfWord(fields.Text("subject"));
  const auto kind = ValueOf(kKinds, word);
  told.has_left = word == kLeft;
  if (!subject) Refuse(fields.PointerTo("subject"), "must be site, map or obstacle");
  if (!kind && !told.has_left) Refuse(fields.PointerTo("change"), "is no kind of change");
  told.change.key = {*subject, fields.Text("id")};
  told.change.kind = kind.value_or(ChangeKind::kUpdated);
  told.change.origin = fields.Text("origin");
  if (told.change.key.id.empty() || told.change.key.id.size() > 256) {
    Refuse(fields.PointerTo("id"), "must have 1 to 256 characters");
  }
  if (told.IsRemoval()) {
    told.change.stamp_us = fields.Integer("stamp_us");
  } else if (!told.has_left) {
    ParseStored(fields, told);
  }
  return told;
}

}  // namespace freelsd
