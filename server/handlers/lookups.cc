#include "server/handlers/lookups.h"

#include "api/api.h"
#include "api/stored/stored.h"

namespace freelsd {

FlightRow ExistingFlight(const Service& service, const Call& call) {
  const std::optional<FlightRow> flight = service.storage.flights.Find(call.Id("flight"));
  if (!flight) throw ApiError("NoSuchFlight", "there is no such flight");
  return *flight;
}

SiteRow ExistingSite(const Service& service, const Call& call) {
  const std::optional<SiteRow> site = service.storage.sites.Find(call.Id("site"));
  if (!site) throw ApiError("NoSuchSite", "there is no such site");
  return *site;
}

JobRow ExistingJob(const Service& service, const Call& call) {
  const std::optional<JobRow> job = service.storage.jobs.Find(call.Id("job"));
  if (!job) throw ApiError("NoSuchJob", "there is no such job");
  return *job;
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
  if (!include) std::erase_if(sites, [](const SiteRow& site) { return site.superseded_by; });
  return sites;
}

StoredSite SiteOf(const SiteRow& row) {
  return ReadStoredSite(row.feature_json,
                        row.approach_json,
                        ParseReplan(row.replan_json).flight.altitude_datum.value_or("unknown"));
}

}  // namespace freelsd
