// Answers a flight as JSON or as a report.
#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "api/api.h"
#include "api/export/report/report.h"
#include "api/stored/stored.h"
#include "server/handlers/export/answer_format.h"
#include "server/handlers/export/left_out.h"
#include "server/handlers/export/report_ground.h"
#include "server/handlers/handlers.h"
#include "server/handlers/lookups.h"
#include "server/handlers/site_rose.h"

namespace freelsd {
namespace {

// Of a flight's sites, so many are reported in full, because each needs a wind rose.
constexpr size_t kMaxNumFullSites = 10;
// Coarser than that of the page: the rose is small on paper, and ten of them are planned.
WindRoseOptions RoseOptions() { return {16, {0.0, 2.5, 5.0, 7.5, 10.0}}; }

void AddTimes(const Service& service, FlightReport& report) {
  std::optional<int64_t> first_us, last_us;
  for (const FrameRow& frame : service.storage.frames.List(report.flight_id)) {
    if (frame.resolved_json.empty()) continue;
    const CaptureTime time = CaptureTimeOf(frame, ParseStoredFrameMeta(frame.resolved_json));
    if (!time.IsDated()) continue;
    first_us = std::min(first_us.value_or(time.earliest_us), time.earliest_us);
    last_us = std::max(last_us.value_or(time.latest_us), time.latest_us);
  }
  if (first_us) report.first_photographed_at = Rfc3339(*first_us);
  if (last_us) report.last_photographed_at = Rfc3339(*last_us);
}

// Without age: a report that is read next year would be wrong.
StoredSite ReportedSiteOf(const SiteRow& row) {
  StoredSite site = SiteOf(row);
  site.age_s.reset();
  return site;
}

// Sorts the flight's sites into those accepted, rejected and superseded. Returns the rows of the
// accepted ones, best first.
std::vector<SiteRow> AddSites(const Service& service, FlightReport& report) {
  std::map<std::string, SiteRow> rows;
  std::vector<StoredSite> sites;
  for (SiteRow& row : SitesOfFlight(service, report.flight_id)) {
    StoredSite site = ReportedSiteOf(row);
    if (row.superseded_by) {
      const std::string at = row.superseded_at_us > 0 ? Rfc3339(row.superseded_at_us) : "unknown";
      report.superseded_sites.push_back(
          {std::move(site), *row.superseded_by, at, row.superseded_detail});
      continue;
    }
    sites.push_back(std::move(site));
    rows.emplace(row.id, std::move(row));
  }
  std::vector<SiteRow> accepted;
  for (StoredSite& site : RankSites(std::move(sites))) {
    if (site.IsRejected()) {
      report.rejected_sites.push_back(std::move(site));
      continue;
    }
    accepted.push_back(std::move(rows.at(site.id)));
    if (report.sites.size() < kMaxNumFullSites) {
      report.sites.push_back({std::move(site), std::nullopt, std::nullopt});
    } else {
      report.further_sites.push_back(std::move(site));
    }
  }
  return accepted;
}

std::optional<WindRose> RoseOf(Service& service,
                               const SiteRow& row,
                               const StopIfUnwanted& stop_if_unwanted) {
  const auto kept = service.maps.Get(service.storage, row.id, row.updated_at_us);
  if (!kept) return std::nullopt;
  const Aircraft& aircraft = kept->replan.flight.aircraft;
  return PlanSiteRose(service, kept, aircraft, RoseOptions(), stop_if_unwanted).rose;
}

void AddMaps(Service& service, const StopIfUnwanted& stop_if_unwanted, FlightReport& report) {
  if (ReadableMaps(service, report.flight_id).empty()) return;
  const FlightPicture picture(service, report.flight_id, stop_if_unwanted);
  report.local_frame = picture.Frame();
  for (const auto& map : picture.maps()) {
    if (!report.wind) report.wind = map->head.wind;
  }
  report.maps = ReportedMapsOf(service, picture);
  for (ReportedSite& site : report.sites) {
    site.ground = LandingPictureOf(picture, site.site);
  }
}

// Without a map of the flight, only sites with maps of their own have a place in world.
LocalFrame FrameOf(const std::vector<SiteRow>& rows) {
  return LocalFrame(rows.empty() ? GeoPoint{} : ParseReplan(rows.front().replan_json).origin);
}

void AddLeftOut(const Service& service, FlightReport& report) {
  std::set<std::string> used;
  for (const auto& map : ReadableMaps(service, report.flight_id)) {
    for (const MapView& view : map->head.views) used.insert(view.frame_id);
  }
  const std::vector<FrameRow> frames = service.storage.frames.List(report.flight_id);
  report.num_photographs = static_cast<int64_t>(frames.size());
  report.photographs_left_out = PhotographsLeftOut(frames, used);
  std::set<int64_t> with_site;
  for (const SiteRow& site : service.storage.sites.List(report.flight_id, std::nullopt)) {
    with_site.insert(site.region_id);
  }
  report.regions_left_out =
      RegionsLeftOut(service.storage.flights.ListRegions(report.flight_id), with_site);
}

FlightReport ReportOf(Service& service,
                      const FlightRow& flight,
                      const StopIfUnwanted& stop_if_unwanted) {
  FlightReport report;
  report.flight_id = flight.id;
  report.name = flight.name;
  report.aircraft = ParseStoredFlight(flight.request_json).aircraft;
  report.altitude_datum = AltitudeDatumOf(flight);
  report.warnings = AllWarnings(flight.warnings_json);
  report.software_version = FREELSD_VERSION;
  report.written_at = Rfc3339(NowUs());
  AddTimes(service, report);
  const std::vector<SiteRow> accepted = AddSites(service, report);
  report.local_frame = FrameOf(accepted);
  AddMaps(service, stop_if_unwanted, report);
  for (size_t i = 0; i < report.sites.size(); ++i) {
    report.sites[i].rose = RoseOf(service, accepted[i], stop_if_unwanted);
  }
  AddLeftOut(service, report);
  return report;
}

}  // namespace

void GetFlightAs(Service& service, const Call& call, httplib::Response& response) {
  constexpr SiteFormat kJson{"json", "application/json", "json"};
  const SiteFormat format = FormatOf(call, {kJson, kReportFormat});
  response.set_header("Vary", "Accept");
  if (std::string_view(format.name) == kJson.name) return GetFlight(service, call, response);
  const FlightRow flight = ExistingFlight(service, call);
  const StopIfUnwanted stop_if_unwanted = WantedBy(service, call);
  const LongPlace place(service.long_queues.files, stop_if_unwanted);
  AnswerReport(FlightReportPage(ReportOf(service, flight, stop_if_unwanted)), response);
}

}  // namespace freelsd
