// Answers sites in the format that ?f= or the Accept header names; the default is GeoJSON.
#include <algorithm>

#include "api/api.h"
#include "api/export/layers/layers.h"
#include "api/export/report/report.h"
#include "api/export/sites/sites.h"
#include "api/stored/stored.h"
#include "server/handlers/export/answer_format.h"
#include "server/handlers/handlers.h"
#include "server/handlers/lookups.h"

namespace freelsd {
namespace {

constexpr SiteFormat kGeoJson{"geojson", "application/geo+json", "geojson"};

std::vector<SiteFormat> FormatsWith(std::initializer_list<SiteFormat> more) {
  std::vector<SiteFormat> formats = more;
  for (const SiteFormat& format : SiteFormats()) formats.push_back(format);
  return formats;
}

// The sites of a flight, best first, each with its rank. They bear the flight's present name.
std::vector<StoredSite> RankedSitesOf(const Service& service,
                                      const std::string& flight_id,
                                      const std::vector<SiteRow>& rows) {
  const std::optional<FlightRow> flight = service.storage.flights.Find(flight_id);
  std::vector<StoredSite> sites;
  sites.reserve(rows.size());
  for (const SiteRow& row : rows) {
    sites.push_back(SiteOf(row));
    if (flight) sites.back().flight_name = flight->name;
  }
  return RankSites(std::move(sites));
}

// The file name marks an unverified site.
std::string FileName(const std::string& id, const SiteFormat& format, bool is_unverified) {
  return id + (is_unverified ? "-UNVERIFIED." : ".") + format.extension;
}

bool IsUnverified(const StoredSite& site) { return site.verdict == "unverified"; }

void Answer(const std::string& body,
            const SiteFormat& format,
            const std::string& file_name,
            httplib::Response& response) {
  response.set_header("Vary", "Accept");
  response.set_header("Content-Disposition", "attachment; filename=\"" + file_name + "\"");
  response.set_content(body, format.media_type);
}

void AnswerSiteReport(const Service& service,
                      const SiteRow& row,
                      const StoredSite& site,
                      httplib::Response& response) {
  const std::optional<SiteMap> map = MapOf(service, row);
  const LocalFrame local_frame(ParseReplan(row.replan_json).origin);
  AnswerReport(SiteReport(site, map.value_or(SiteMap()), local_frame), response);
}

}  // namespace

void GetSiteAs(Service& service, const Call& call, httplib::Response& response) {
  const SiteRow row = ExistingSite(service, call);
  const SiteFormat format = FormatOf(call, FormatsWith({kGeoJson, kReportFormat}));
  const ExportOptions options = ExportOptionsOf(call);
  if (std::string_view(format.name) == kGeoJson.name) {
    response.set_header("Vary", "Accept");
    return GetSite(service, call, response);
  }
  const bool is_superseded = row.superseded_by && call.Query("include") != "superseded";
  if (is_superseded && std::string_view(format.name) != kReportFormat.name) {
    throw ApiError("SiteRejected",
                   "superseded: on the later map of " + *row.superseded_by + " " +
                       (row.superseded_detail.empty() ? "its plan fails" : row.superseded_detail) +
                       "; include=superseded exports it nevertheless");
  }
  for (const StoredSite& site :
       RankedSitesOf(service, row.flight_id, SitesOfFlight(service, row.flight_id))) {
    if (site.id != row.id) continue;
    if (std::string_view(format.name) == kReportFormat.name) {
      const LongPlace place(service.long_queues.files, WantedBy(service, call));
      return AnswerSiteReport(service, row, site, response);
    }
    const std::string body = ExportSites(format.name, {site}, options);
    Answer(body, format, FileName(row.id, format, IsUnverified(site)), response);
  }
}

void GetFlightSitesAs(Service& service, const Call& call, httplib::Response& response) {
  const FlightRow flight = ExistingFlight(service, call);
  const SiteFormat format = FormatOf(call, FormatsWith({kGeoJson}));
  const ExportOptions options = ExportOptionsOf(call);
  if (std::string_view(format.name) == kGeoJson.name) {
    response.set_header("Vary", "Accept");
    return GetFlightSites(service, call, response);
  }
  const std::vector<StoredSite> sites =
      RankedSitesOf(service, flight.id, ListedSites(service, call, flight.id, std::nullopt));
  // A format that shows verdicts is named after its first site; any other after all sites.
  const auto end = format.tells_verdicts && !sites.empty() ? sites.begin() + 1 : sites.end();
  const bool is_unverified = std::any_of(sites.begin(), end, IsUnverified);
  const std::string body = ExportSites(format.name, sites, options);
  Answer(body, format, FileName(flight.id, format, is_unverified), response);
}

void GetLayerWorldFile(Service& service, const Call& call, httplib::Response& response) {
  const SiteRow site = ExistingSite(service, call);
  const std::vector<std::string> names = LayerNames();
  if (std::find(names.begin(), names.end(), call.Id("layer")) == names.end()) {
    throw ApiError("NoSuchLayer", "there is no such layer");
  }
  const std::optional<SiteMap> map = MapOf(service, site);
  if (!map) throw ApiError("NoMap", "the site has no map");
  const LocalFrame local_frame(ParseReplan(site.replan_json).origin);
  response.set_content(LayerWorldFile(*map, local_frame), "text/plain");
}

}  // namespace freelsd
