#include "api/export/site_export.h"

#include <cmath>
#include <cstdio>

#include <GeographicLib/Geodesic.hpp>

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
GeoPoint CenterOf(const nlohmann::json& closed_line, const GeoPoint& touchdown) {
  const LocalFrame local_frame(touchdown);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (size_t i = 1; i < closed_line.size(); ++i) {
    sum += local_frame.WorldFromGeo(PlaceOf(closed_line[i]));
  }
  return local_frame.GeoFromWorld(sum / static_cast<double>(closed_line.size() - 1));
}

FinalPlaces ReadFinal(const nlohmann::json& approach, const GeoPoint& touchdown) {
  const nlohmann::json& line = FeatureOfKind(approach, "approach");
  const nlohmann::json& loiter = FeatureOfKind(approach, "loiter");
  FinalPlaces places;
  places.start = PlaceOf(line.at("geometry").at("coordinates").at(0));
  places.loiter_center = CenterOf(loiter.at("geometry").at("coordinates"), touchdown);
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

}  // namespace

std::string SitePlaces::Name() const {
  if (IsRejected()) return id + " REJECTED";
  return verdict == "unverified" ? id + " UNVERIFIED" : id;
}

SitePlaces ReadSite(const StoredSite& site) {
  const nlohmann::json feature = nlohmann::json::parse(site.feature_json);
  SitePlaces places;
  places.properties = feature.at("properties");
  places.id = places.properties.at("id");
  places.verdict = places.properties.value("verdict", "rejected");
  places.altitude_datum = site.altitude_datum;
  places.touchdown = PlaceOf(feature.at("geometry").at("coordinates"));
  if (site.approach_json.empty()) return places;
  const nlohmann::json approach = nlohmann::json::parse(site.approach_json);
  places.final_places = ReadFinal(approach, places.touchdown);
  places.loiter_line = FeatureOfKind(approach, "loiter").at("geometry").at("coordinates");
  places.profile = approach.value("profile", nlohmann::json());
  return places;
}

std::vector<SitePlaces> SafeSites(const std::vector<StoredSite>& sites, bool needs_final) {
  std::vector<SitePlaces> safe;
  for (const StoredSite& site : sites) {
    SitePlaces places = ReadSite(site);
    if (places.IsRejected()) continue;
    if (needs_final && !places.final_places) {
      throw ApiError("NoApproach", "site " + places.id + " has no approach");
    }
    safe.push_back(std::move(places));
  }
  if (safe.empty()) {
    std::string detail = "only a site that is not rejected is written into such a file";
    if (sites.size() == 1) {
      const std::string summary = ReadSite(sites.front()).properties.value("summary", "rejected");
      detail = "not written into such a file: " + summary;
    }
    throw ApiError("SiteRejected", detail);
  }
  return safe;
}

AltitudeFrame FrameAboveHome(const ExportOptions& options) {
  if (options.home_altitude_m) return {true, *options.home_altitude_m};
  throw ApiError(
      "AltitudeUnknown",
      "this file tells altitudes above home: give home_altitude_m, in the flight's datum",
      {{"home_altitude_m", "is missing"}});
}

AltitudeFrame FrameOf(const std::vector<SitePlaces>& sites, const ExportOptions& options) {
  if (options.home_altitude_m) return {true, *options.home_altitude_m};
  for (const SitePlaces& site : sites) {
    if (site.altitude_datum == "amsl") continue;
    throw ApiError("AltitudeUnknown",
                   "the flight's altitude_datum is " + site.altitude_datum +
                       ", not amsl: give home_altitude_m, in the flight's datum, for altitudes "
                       "above home",
                   {{"home_altitude_m", "is missing"}});
  }
  return {false, 0.0};
}

std::string FixedText(double number, int num_decimals) {
  char text[64];
  std::snprintf(text, sizeof(text), "%.*f", num_decimals, number);
  return text;
}

std::string EscapeXml(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&') {
      escaped += "&amp;";
    } else if (c == '<') {
      escaped += "&lt;";
    } else if (c == '>') {
      escaped += "&gt;";
    } else if (c == '"') {
      escaped += "&quot;";
    } else if (c == '\'') {
      escaped += "&#39;";
    } else if (static_cast<unsigned char>(c) >= ' ' || c == '\n' || c == '\t') {
      escaped += c;
    }
  }
  return escaped;
}

}  // namespace freelsd
