#include <algorithm>
#include <cmath>
#include <sstream>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "server/handlers/bounding_box.h"
#include "server/handlers/handlers.h"
#include "server/handlers/lookups.h"
#include "server/recall/recall.h"

namespace freelsd {
namespace {

constexpr char kGeoJson[] = "application/geo+json";

std::vector<nlohmann::json> FeaturesOf(const std::vector<SiteRow>& sites) {
  std::vector<nlohmann::json> features;
  features.reserve(sites.size());
  for (const SiteRow& site : sites) {
    features.push_back(FeatureOf(site));
  }
  return features;
}

size_t ParseLimit(const Call& call) {
  constexpr auto kMax = static_cast<double>(kLimits.answer.max_num_listed_sites);
  const double limit = call.QueryNumber("limit").value_or(kMax);
  if (limit < 1 || limit > kMax || limit != std::floor(limit)) {
    const std::string rule = "must be 1 to " + std::to_string(kLimits.answer.max_num_listed_sites);
    throw ApiError("InvalidValue", "limit: " + rule, {{"limit", rule}});
  }
  return static_cast<size_t>(limit);
}

}  // namespace

void GetRegions(Service& service, const Call& call, httplib::Response& response) {
  const FlightRow flight = ExistingFlight(service, call);
  std::string features;
  for (const RegionRow& region : service.storage.flights.ListRegions(flight.id)) {
    features += (features.empty() ? "" : ",") + region.feature_json;
  }
  response.set_content(R"({"type":"FeatureCollection","features":[)" + features + "]}", kGeoJson);
}

void GetRegionHistory(Service& service, const Call& call, httplib::Response& response) {
  const FlightRow flight = ExistingFlight(service, call);
  for (const RegionRow& region : service.storage.flights.ListRegions(flight.id)) {
    if (std::to_string(region.id) != call.Id("region")) continue;
    response.set_content(region.history_json, "application/json");
    return;
  }
  throw ApiError("NoSuchRegion", "there is no such region in this flight");
}

void GetFlightSites(Service& service, const Call& call, httplib::Response& response) {
  const FlightRow flight = ExistingFlight(service, call);
  const auto features = FeaturesOf(ListedSites(service, call, flight.id, std::nullopt));
  response.set_content(RankedSites(features).dump(), kGeoJson);
}

void GetSites(Service& service, const Call& call, httplib::Response& response) {
  const std::optional<BoundingBox> box = ParseBoundingBox(call);
  const size_t limit = ParseLimit(call);
  nlohmann::json sites = RankedSites(FeaturesOf(ListedSites(service, call, std::nullopt, box)));
  nlohmann::json& features = sites["features"];
  while (features.size() > limit) features.erase(features.size() - 1);
  response.set_content(sites.dump(), kGeoJson);
}

// Answers the site with its rank in its flight.
void GetSite(Service& service, const Call& call, httplib::Response& response) {
  const SiteRow site = ExistingSite(service, call);
  const auto ranked =
      RankedSites(FeaturesOf(service.storage.sites.List(site.flight_id, std::nullopt)));
  for (const nlohmann::json& feature : ranked["features"]) {
    if (feature["properties"]["id"] == site.id) response.set_content(feature.dump(), kGeoJson);
  }
}

void DeleteSite(Service& service, const Call& call, httplib::Response& response) {
  {
    const std::lock_guard lock(service.sites_mutex);
    ForgetSite(service.storage, service.maps, ExistingSite(service, call).id);
  }
  service.alternates.WakeAll();
  response.status = 204;
}

}  // namespace freelsd
