// All stored sites of an area that recall may name, to preload an aircraft.
#include <map>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/export/export.h"
#include "server/bounding_box.h"
#include "server/handlers.h"
#include "server/replan.h"

namespace freelsd {
namespace {

constexpr size_t kMaxNumExported = 1000;

std::vector<StoredSite> SitesIn(const Service& service, const BoundingBox& box) {
  std::vector<nlohmann::json> features;
  std::map<std::string, SiteRow> rows;
  for (const auto& recall : service.storage.ListRecallable(box)) {
    std::optional<SiteRow> row = service.storage.FindSite(recall->site_id);
    if (!row || !rows.emplace(row->id, *row).second) continue;
    features.push_back(nlohmann::json::parse(row->feature_json));
  }
  std::vector<StoredSite> sites;
  const nlohmann::json ranked = RankedSites(features);
  for (const nlohmann::json& feature : ranked.at("features")) {
    const SiteRow& row = rows.at(feature["properties"]["id"].get<std::string>());
    sites.push_back(
        {feature.dump(), row.approach_json, ParseReplan(row.replan_json).flight.altitude_datum});
    if (sites.size() == kMaxNumExported) break;
  }
  return sites;
}

std::string GeoJsonOf(const std::vector<StoredSite>& sites) {
  nlohmann::json collection{{"type", "FeatureCollection"}, {"features", nlohmann::json::array()}};
  for (const StoredSite& site : sites) {
    collection["features"].push_back(nlohmann::json::parse(site.feature_json));
  }
  return collection.dump();
}

// Altitudes above one home can only be told of sites that measure from the same zero.
double HomeAltitude(const Call& call, const std::vector<StoredSite>& sites) {
  const std::optional<double> home_altitude_m = call.QueryNumber("home_altitude_m");
  if (!home_altitude_m) {
    throw ApiError("AltitudeUnknown",
                   "this file tells altitudes above home: give home_altitude_m",
                   {{"home_altitude_m", "is missing"}});
  }
  for (const StoredSite& site : sites) {
    if (site.altitude_datum == sites.front().altitude_datum) continue;
    throw ApiError("AltitudeUnknown", "the area's sites have different altitude datums");
  }
  return *home_altitude_m;
}

void AnswerFile(const std::string& text,
                const char* type,
                const char* name,
                httplib::Response& response) {
  response.set_header("Content-Disposition", std::string("attachment; filename=\"") + name + '"');
  response.set_content(text, type);
}

}  // namespace

void GetEmergencyExport(Service& service, const Call& call, httplib::Response& response) {
  const std::string format = call.Query("f").value_or("geojson");
  if (format != "geojson" && format != "rally" && format != "plan") {
    const std::string detail = "f: must be geojson, plan or rally";
    throw ApiError("InvalidQuery", detail, {{"f", detail}});
  }
  const BoundingBox whole_earth{-180.0, -90.0, 180.0, 90.0};
  std::vector<StoredSite> sites = SitesIn(service, ParseBoundingBox(call).value_or(whole_earth));
  if (format == "geojson") {
    response.set_content(GeoJsonOf(sites), "application/geo+json");
    return;
  }
  const double home_altitude_m = HomeAltitude(call, sites);
  // A file to fly by has only what has a way down.
  std::erase_if(sites, [](const StoredSite& site) { return site.approach_json.empty(); });
  const std::string text = ExportSites(format, sites, {home_altitude_m});
  if (format == "plan") return AnswerFile(text, "application/json", "emergency.plan", response);
  AnswerFile(text, "text/plain", "emergency-rally.txt", response);
}

}  // namespace freelsd
