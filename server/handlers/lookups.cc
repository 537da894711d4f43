#include "server/handlers/lookups.h"

#include <cmath>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/stored/stored.h"
#include "server/recall/recall.h"

namespace freelsd {

FlightRow ExistingFlight(const Service& service, const Call& call) {
  const std::optional<FlightRow> flight = service.storage.flights.Find(call.Id("flight"));
  if (!flight) throw ApiError("NoSuchFlight", "there is no such flight");
  return *flight;
}

SiteRow ExistingSite(const Service& service, const Call& call) {
  std::optional<SiteRow> site = service.storage.sites.Find(call.Id("site"));
  if (!site) throw ApiError("NoSuchSite", "there is no such site");
  return AsObstructed({service.storage, service.maps}, std::move(*site));
}

JobRow ExistingJob(const Service& service, const Call& call) {
  const std::optional<JobRow> job = service.storage.jobs.Find(call.Id("job"));
  if (!job) throw ApiError("NoSuchJob", "there is no such job");
  return *job;
}

StopIfUnwanted WantedBy(const Service& service, const Call& call) {
  return [&service, &body = call.body] {
    if (service.intake.is_stopping) throw ApiError("ShuttingDown", "the server is stopping");
    if (body.HasClientLeft()) throw ApiError("Unavailable", "the client has left");
  };
}

namespace {

std::vector<SiteRow> Obstructed(const Service& service, std::vector<SiteRow> sites) {
  for (SiteRow& site : sites) {
    site = AsObstructed({service.storage, service.maps}, std::move(site));
  }
  return sites;
}

// A doubted site is at most unverified.
void Doubt(const SiteRow& row, std::string& verdict, std::string& summary) {
  constexpr std::string_view kLandable = "Landable";
  if (verdict == "landable") verdict = "unverified";
  if (summary.starts_with(kLandable)) summary.replace(0, kLandable.size(), "Unverified");
  summary += (summary.empty() ? "" : " ") + DoubtSentence(row);
}

void AddDoubt(const SiteRow& row, nlohmann::json& properties) {
  std::string verdict = properties.value("verdict", "rejected");
  std::string summary = properties.value("summary", "");
  Doubt(row, verdict, summary);
  properties["verdict"] = verdict;
  properties["summary"] = summary;
  properties["warnings"].push_back(DoubtSentence(row));
  properties["doubted_by"] = row.JudgeId();
  properties["doubted_at"] = nullptr;
  if (row.superseded_at_us > 0) properties["doubted_at"] = Rfc3339(row.superseded_at_us);
  properties["doubt_reason"] = row.superseded_reason;
  properties["doubt_detail"] = row.superseded_detail;
}

}  // namespace

std::vector<SiteRow> SitesOfFlight(const Service& service, const std::string& flight_id) {
  return Obstructed(service, service.storage.sites.List(flight_id, std::nullopt));
}

std::vector<SiteRow> ListedSites(const Service& service,
                                 const Call& call,
                                 const std::optional<std::string>& flight_id,
                                 const std::optional<BoundingBox>& box) {
  const std::optional<std::string> include = call.Query("include");
  if (include && *include != "superseded") {
    throw ApiError(
        "InvalidQuery", "include: must be superseded", {{"include", "must be superseded"}});
  }
  std::vector<SiteRow> sites = service.storage.sites.List(flight_id, box);
  if (!include) {
    std::erase_if(sites,
                  [](const SiteRow& site) { return site.superseded_by && !site.IsContested(); });
  }
  return Obstructed(service, std::move(sites));
}

nlohmann::json FeatureOf(const SiteRow& row, int64_t now_us) {
  nlohmann::json feature = nlohmann::json::parse(row.feature_json);
  nlohmann::json& properties = feature["properties"];
  properties.update(GroundAgeJson(row.LastSeenUs(), now_us));
  if (row.IsDoubted()) AddDoubt(row, properties);
  if (!row.superseded_by) return feature;
  properties["superseded_by"] = *row.superseded_by;
  // The order of the two maps is not known.
  if (row.superseded_at_us == 0) return feature;
  properties["superseded_at"] = Rfc3339(row.superseded_at_us);
  properties["superseded_reason"] = row.superseded_reason;
  properties["superseded_detail"] = row.superseded_detail;
  return feature;
}

StoredSite SiteOf(const SiteRow& row) {
  const FlightRequest flight = ParseReplan(row.replan_json).flight;
  StoredSite site = ReadStoredSite(
      row.feature_json, row.approach_json, flight.altitude_datum.value_or("unknown"));
  site.flight_name = flight.name;
  if (row.LastSeenUs() > 0) site.last_seen_at = Rfc3339(row.LastSeenUs());
  site.age_s = GroundAgeS(row.LastSeenUs(), NowUs());
  if (row.IsDoubted()) {
    site.is_doubted = true;
    std::string summary = site.summary.value_or("");
    Doubt(row, site.verdict, summary);
    site.summary = summary;
    site.warnings.push_back(DoubtSentence(row));
  }
  site.is_superseded = row.superseded_by.has_value();
  if (site.is_superseded) {
    site.warnings.push_back("superseded: on the later map of " + *row.superseded_by + " " +
                            row.superseded_detail);
  }
  return site;
}

ExportOptions ExportOptionsOf(const Call& call) {
  constexpr double kMaxHomeAltitudeM = 10000.0;
  ExportOptions options{call.QueryNumber("home_altitude_m")};
  if (std::abs(options.home_altitude_m.value_or(0.0)) > kMaxHomeAltitudeM) {
    const std::string detail = "home_altitude_m: must be in [-10000, 10000]";
    throw ApiError("InvalidQuery", detail, {{"home_altitude_m", detail}});
  }
  const std::string firmware = call.Query("firmware").value_or("px4");
  if (firmware != "px4" && firmware != "ardupilot") {
    const std::string detail = "firmware: must be px4 or ardupilot";
    throw ApiError("InvalidQuery", detail, {{"firmware", detail}});
  }
  if (firmware == "ardupilot") options.firmware = Firmware::kArduPilot;
  return options;
}

std::optional<SiteMap> MapOf(const Service& service, const SiteRow& site) {
  const auto kept = service.maps.Get(service.storage, site.id, site.updated_at_us);
  if (!kept) return std::nullopt;
  const FlightRequest& flight = kept->replan.flight;
  const PipelineOptions& options = flight.options;
  SiteMap map = CropAround(kept->site_map.map,
                           kept->site_map.layers,
                           kept->replan.request.footprint,
                           options.backend.max_surroundings_m);
  if (map.map.elevation.empty()) return map;
  map.layers = WithLimits(map.map,
                          map.layers,
                          {flight.aircraft.max_slope_deg, flight.aircraft.max_roughness_m},
                          options.hazard);
  map.layers = WithObstacleHazards(std::move(map.layers), kept->obstacles, {});
  return map;
}

}  // namespace freelsd
