// Finds the flight, site or job whose id is in the URL.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "api/export/sites/sites.h"
#include "api/stored/stored.h"
#include "server/http/http.h"
#include "server/jobs/jobs.h"

namespace freelsd {

// Throws ApiError NoSuchFlight.
FlightRow ExistingFlight(const Service& service, const Call& call);
// Throws ApiError NoSuchSite. As obstacles leave it (AsObstructed).
SiteRow ExistingSite(const Service& service, const Call& call);
// Throws ApiError NoSuchJob.
JobRow ExistingJob(const Service& service, const Call& call);

// Throws ApiError if the client of the call has left, or if the server is stopping. Both arguments
// must outlive it.
StopIfUnwanted WantedBy(const Service& service, const Call& call);

// The flight's sites, superseded ones included, as obstacles leave them.
std::vector<SiteRow> SitesOfFlight(const Service& service, const std::string& flight_id);
// Stored sites as obstacles leave them, without superseded ones unless the query says
// include=superseded. Throws ApiError.
std::vector<SiteRow> ListedSites(const Service& service,
                                 const Call& call,
                                 const std::optional<std::string>& flight_id,
                                 const std::optional<BoundingBox>& box);
// The stored feature, with the age of its ground at `now_us`, and with the site's standing on later
// maps.
nlohmann::json FeatureOf(const SiteRow& row, int64_t now_us = NowUs());
// The query's home_altitude_m and firmware. Throws ApiError InvalidQuery.
ExportOptions ExportOptionsOf(const Call& call);
// The row as a struct, without its rank.
StoredSite SiteOf(const SiteRow& row);
// The site's stored map; its hazards are also those of the obstacles in force. Its
// min_grass_posterior is that of the flight's options. Nothing if the site has no map.
std::optional<SiteMap> MapOf(const Service& service, const SiteRow& site);

}  // namespace freelsd
