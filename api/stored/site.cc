#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <GeographicLib/Geodesic.hpp>
#include <nlohmann/json.hpp>

#include "api/plan_json.h"
#include "api/stored/stored.h"

namespace freelsd {
namespace {

GeoPoint PlaceOf(const nlohmann::json& position) {
  return {position.at(1), position.at(0), position.at(2)};
}

const nlohmann::json& FeatureOfKind(const nlohmann::json& approach, const std::string& kind) {
  for (const nlohmann::json& feature : approach.at("features")) {
    if (feature.at("properties").at("kind") == kind) return feature;
  }
  throw std::runtime_error("stored approach: it has no " + kind);
}

// Mean of a closed line's corners, taken in metres: safe at the antimeridian.
GeoPoint CenterOf(const std::vector<GeoPoint>& closed_line, const GeoPoint& touchdown) {
  const LocalFrame local_frame(touchdown);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (size_t i = 1; i < closed_line.size(); ++i) {
    sum += local_frame.WorldFromGeo(closed_line[i]);
  }
  return local_frame.GeoFromWorld(sum / static_cast<double>(closed_line.size() - 1));
}

FinalPlaces ReadFinal(const nlohmann::json& approach, const GeoPoint& touchdown) {
  const nlohmann::json& line = FeatureOfKind(approach, "approach");
  const nlohmann::json& loiter = FeatureOfKind(approach, "loiter");
  FinalPlaces places;
  places.start = PlaceOf(line.at("geometry").at("coordinates").at(0));
  for (const nlohmann::json& position : loiter.at("geometry").at("coordinates")) {
    places.circle.push_back(PlaceOf(position));
  }
  places.loiter_center = CenterOf(places.circle, touchdown);
  places.loiter_center.altitude_m = places.start.altitude_m;
  places.loiter_radius_m = loiter.at("properties").at("radius_m");
  places.is_right_turn = loiter.at("properties").at("direction") == "right";
  double heading_at_start;
  GeographicLib::Geodesic::WGS84().Inverse(places.start.latitude_deg,
                                           places.start.longitude_deg,
                                           touchdown.latitude_deg,
                                           touchdown.longitude_deg,
                                           heading_at_start,
                                           places.heading_deg);
  places.distance_m = LocalFrame(touchdown).WorldFromGeo(places.start).head<2>().norm();
  if (places.heading_deg < 0.0) places.heading_deg += 360.0;
  places.height_m = places.start.altitude_m - touchdown.altitude_m;
  return places;
}

std::optional<double> NumberIn(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number()) return std::nullopt;
  return found->get<double>();
}

std::optional<int64_t> CountIn(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number_integer()) return std::nullopt;
  return found->get<int64_t>();
}

std::optional<std::string> TextIn(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_string()) return std::nullopt;
  return found->get<std::string>();
}

std::optional<nlohmann::json> ObjectIn(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_object()) return std::nullopt;
  return *found;
}

std::vector<ProfilePoint> ReadProfile(const nlohmann::json& approach) {
  std::vector<ProfilePoint> points;
  const std::optional<nlohmann::json> profile = ObjectIn(approach, "profile");
  if (!profile) return points;
  const auto altitude = [&profile](const char* name, size_t i) -> std::optional<double> {
    const nlohmann::json& value = profile->at(name).at(i);
    if (value.is_null()) return std::nullopt;
    return value.get<double>();
  };
  const nlohmann::json& distances = profile->at("distance_m");
  for (size_t i = 0; i < distances.size(); ++i) {
    points.push_back({distances[i].get<double>(), altitude("path_m", i), altitude("terrain_m", i)});
  }
  return points;
}

std::vector<GeoPoint> ReadGroundRoll(const nlohmann::json& approach) {
  std::vector<GeoPoint> corners;
  for (const nlohmann::json& feature : approach.at("features")) {
    if (feature.at("properties").at("kind") != "ground_roll") continue;
    const nlohmann::json& ring = feature.at("geometry").at("coordinates").at(0);
    // The ring is closed: its last corner is the first one again.
    for (size_t i = 0; i + 1 < ring.size(); ++i) corners.push_back(PlaceOf(ring[i]));
  }
  return corners;
}

std::optional<StoredGoAround> ReadGoAround(const nlohmann::json& approach) {
  for (const nlohmann::json& feature : approach.at("features")) {
    const nlohmann::json& properties = feature.at("properties");
    if (properties.at("kind") != "go_around") continue;
    const nlohmann::json& line = feature.at("geometry").at("coordinates");
    return StoredGoAround{properties.at("no_return_distance_m").get<double>(),
                          properties.at("unseen_ratio").get<double>(),
                          PlaceOf(line.at(0)),
                          PlaceOf(line.at(1))};
  }
  return std::nullopt;
}

std::vector<StoredRejection> ReadRejections(const nlohmann::json& properties) {
  std::vector<StoredRejection> rejections;
  for (const nlohmann::json& each : properties.value("rejections", nlohmann::json::array())) {
    rejections.push_back(
        {TextIn(each, "reason").value_or(""), TextIn(each, "detail").value_or("")});
  }
  return rejections;
}

std::vector<std::string> ReadWarnings(const nlohmann::json& properties) {
  std::vector<std::string> warnings;
  for (const nlohmann::json& each : properties.value("warnings", nlohmann::json::array())) {
    if (each.is_string()) warnings.push_back(each);
  }
  return warnings;
}

std::optional<double> FreeLengthOf(const nlohmann::json& properties,
                                   const nlohmann::json& aircraft) {
  if (const auto usable_m = NumberIn(properties, "usable_length_m")) return usable_m;
  const auto disc_m = NumberIn(aircraft, "touchdown_uncertainty_m");
  const auto roll_m = NumberIn(aircraft, "ground_roll_m");
  if (!disc_m || !roll_m) return std::nullopt;
  return *disc_m + std::max(*disc_m, *roll_m);
}

StoredSite ReadProperties(const nlohmann::json& properties) {
  StoredSite site;
  site.id = properties.at("id");
  site.verdict = TextIn(properties, "verdict").value_or("rejected");
  site.rank = CountIn(properties, "rank");
  site.summary = TextIn(properties, "summary");
  site.reject_reason = TextIn(properties, "reject_reason");
  site.updated_at = TextIn(properties, "updated_at");
  site.score = NumberIn(properties, "score");
  site.grade = NumberIn(properties, "grade");
  site.num_observations = CountIn(properties, "num_observations");
  site.num_grass_observations = CountIn(properties, "num_grass_observations");
  site.area_m2 = NumberIn(properties, "area_m2");
  site.usable_length_m = NumberIn(properties, "usable_length_m");
  site.usable_width_m = NumberIn(properties, "usable_width_m");
  site.hazard_distance_m = NumberIn(properties, "hazard_distance_m");
  site.slope_deg = NumberIn(properties, "slope_deg");
  site.roughness_m = NumberIn(properties, "roughness_m");
  site.unseen_ratio = NumberIn(properties, "unseen_ratio");
  if (const auto aircraft = ObjectIn(properties, "aircraft")) {
    site.landing_airspeed_mps = NumberIn(*aircraft, "landing_airspeed_mps");
    site.free_length_m = FreeLengthOf(properties, *aircraft);
  }
  if (const auto wind = ObjectIn(properties, "wind")) {
    site.wind = StoredWind{NumberIn(*wind, "east_mps"), NumberIn(*wind, "north_mps")};
  }
  if (const auto approach = ObjectIn(properties, "approach")) {
    const nlohmann::json obstacle =
        ObjectIn(*approach, "tightest_obstacle").value_or(nlohmann::json::object());
    site.approach = StoredClearance{NumberIn(*approach, "min_clearance_m"),
                                    NumberIn(obstacle, "clearance_m"),
                                    NumberIn(obstacle, "distance_m")};
  }
  site.is_experiment = TextIn(properties, "memory") == "none";
  site.rejections = ReadRejections(properties);
  site.warnings = ReadWarnings(properties);
  return site;
}

}  // namespace

std::string StoredSite::Name() const {
  const bool has_name = !flight_name.empty() && rank;
  const std::string name = has_name ? flight_name + " " + std::to_string(*rank) : id;
  const std::string kind = is_experiment ? name + " EXPERIMENT" : name;
  if (is_superseded) return kind + " SUPERSEDED";
  if (IsRejected()) return kind + " REJECTED";
  return verdict == "unverified" ? kind + " UNVERIFIED" : kind;
}

StoredSite ReadStoredSite(const std::string& feature_json,
                          const std::string& approach_json,
                          const std::string& altitude_datum) {
  const nlohmann::json feature = nlohmann::json::parse(feature_json);
  StoredSite site = ReadProperties(feature.at("properties"));
  site.altitude_datum = altitude_datum;
  site.touchdown = PlaceOf(feature.at("geometry").at("coordinates"));
  if (approach_json.empty()) return site;
  const nlohmann::json approach = nlohmann::json::parse(approach_json);
  site.final_places = ReadFinal(approach, site.touchdown);
  site.ground_roll = ReadGroundRoll(approach);
  site.profile = ReadProfile(approach);
  site.go_around = ReadGoAround(approach);
  return site;
}

std::vector<StoredSite> RankSites(std::vector<StoredSite> sites) {
  const auto key = [](const StoredSite& site) {
    RankKey rank = RankKeyOf(site.verdict, site.score.value_or(0.0), site.id);
    if (site.is_doubted && !site.IsRejected()) std::get<int>(rank) = kDoubtedRank;
    return rank;
  };
  std::stable_sort(
      sites.begin(), sites.end(), [&key](const auto& a, const auto& b) { return key(a) < key(b); });
  int64_t rank = 0;
  for (StoredSite& site : sites) site.rank = ++rank;
  return sites;
}

}  // namespace freelsd
