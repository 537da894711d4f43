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

StoredSite SiteOf(const SiteRow& row) {
  return ReadStoredSite(
      row.feature_json, row.approach_json, ParseReplan(row.replan_json).flight.altitude_datum);
}

}  // namespace freelsd
