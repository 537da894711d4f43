// All stored sites of an area that recall may name, to preload an aircraft. Sites whose plan meets
// an obstacle are left out.
#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/export/sites/sites.h"
#include "api/stored/stored.h"
#include "server/handlers/bounding_box.h"
#include "server/handlers/handlers.h"
#include "server/handlers/lookups.h"
#include "server/recall/recall.h"

namespace freelsd {
namespace {

std::vector<SiteRow> RowsIn(const Service& service, const BoundingBox& box) {
  std::set<std::string> ids;
  std::vector<SiteRow> rows;
  for (const auto& recall : service.storage.sites.ListRecallable(box)) {
    std::optional<SiteRow> row = service.storage.sites.Find(recall->site_id);
    if (!row || !ids.insert(row->id).second) continue;
    if (ObstructionOf({service.storage, service.maps}, *row)) continue;
    rows.push_back(std::move(*row));
  }
  return rows;
}

std::vector<StoredSite> SitesOf(const std::vector<SiteRow>& rows) {
  std::vector<StoredSite> sites;
  sites.reserve(rows.size());
  for (const SiteRow& row : rows) sites.push_back(SiteOf(row));
  sites = RankSites(std::move(sites));
  if (sites.size() > kLimits.answer.max_num_exported_sites)
    sites.resize(kLimits.answer.max_num_exported_sites);
  return sites;
}

std::string GeoJsonOf(const std::vector<SiteRow>& rows) {
  std::vector<nlohmann::json> features;
  features.reserve(rows.size());
  const int64_t now_us = NowUs();
  for (const SiteRow& row : rows) features.push_back(FeatureOf(row, now_us));
  nlohmann::json collection = RankedSites(std::move(features));
  auto& ranked = collection["features"].get_ref<nlohmann::json::array_t&>();
  if (ranked.size() > kLimits.answer.max_num_exported_sites)
    ranked.resize(kLimits.answer.max_num_exported_sites);
  return collection.dump();
}

// An altitude above home needs sites with one common altitude datum.
void RequireHome(const ExportOptions& options, const std::vector<StoredSite>& sites) {
  if (!options.home_altitude_m) {
    throw ApiError("AltitudeUnknown",
                   "this format has altitudes above home: home_altitude_m is needed",
                   {{"home_altitude_m", "is missing"}});
  }
  for (const StoredSite& site : sites) {
    if (site.altitude_datum == sites.front().altitude_datum) continue;
    throw ApiError("AltitudeUnknown", "the area's sites have different altitude datums");
  }
}

void AnswerFile(const std::string& text,
                const char* type,
                const std::string& name,
                httplib::Response& response) {
  response.set_header("Content-Disposition", "attachment; filename=\"" + name + '"');
  response.set_content(text, type);
}

}  // namespace

void GetEmergencyExport(Service& service, const Call& call, httplib::Response& response) {
  const std::string format = call.Query("f").value_or("geojson");
  if (format != "geojson" && format != "rally" && format != "plan") {
    const std::string detail = "f: must be geojson, plan or rally";
    throw ApiError("InvalidQuery", detail, {{"f", detail}});
  }
  const ExportOptions options = ExportOptionsOf(call);
  const BoundingBox whole_earth{-180.0, -90.0, 180.0, 90.0};
  const std::vector<SiteRow> rows = RowsIn(service, ParseBoundingBox(call).value_or(whole_earth));
  if (format == "geojson") {
    response.set_content(GeoJsonOf(rows), "application/geo+json");
    return;
  }
  std::vector<StoredSite> sites = SitesOf(rows);
  RequireHome(options, sites);
  // A file for navigation contains only sites with an approach.
  std::erase_if(sites,
                [](const StoredSite& site) { return !site.final_places || site.IsRejected(); });
  const std::string text = ExportSites(format, sites, options);
  const bool is_unverified = std::any_of(sites.begin(), sites.end(), [](const StoredSite& site) {
    return site.verdict == "unverified";
  });
  const std::string mark = is_unverified ? "-UNVERIFIED." : ".";
  if (format == "plan") {
    return AnswerFile(text, "application/json", "emergency" + mark + "plan", response);
  }
  AnswerFile(text, "text/plain", "emergency-rally" + mark + "txt", response);
}

}  // namespace freelsd
