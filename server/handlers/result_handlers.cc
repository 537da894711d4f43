#include <algorithm>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "server/handlers/bounding_box.h"
#include "server/handlers/handlers.h"
#include "server/handlers/lookups.h"
#include "server/handlers/new_look.h"
#include "server/handlers/paging.h"
#include "server/recall/recall.h"

namespace freelsd {
namespace {

constexpr char kGeoJson[] = "application/geo+json";

std::vector<nlohmann::json> FeaturesOf(const std::vector<SiteRow>& sites) {
  std::vector<nlohmann::json> features;
  features.reserve(sites.size());
  const int64_t now_us = NowUs();
  for (const SiteRow& site : sites) features.push_back(FeatureOf(site, now_us));
  return features;
}

struct RankedRow {
  RankKey key;
  const SiteRow* row = nullptr;
};

// One feature is parsed at a time: all of them together take many times the memory of their text.
std::vector<RankedRow> Ranked(const std::vector<SiteRow>& sites) {
  std::vector<RankedRow> ranked;
  ranked.reserve(sites.size());
  const int64_t now_us = NowUs();
  for (const SiteRow& site : sites) ranked.push_back({RankKeyOf(FeatureOf(site, now_us)), &site});
  std::sort(ranked.begin(), ranked.end(), [](const RankedRow& a, const RankedRow& b) {
    return a.key < b.key;
  });
  return ranked;
}

}  // namespace

void GetRegions(Service& service, const Call& call, httplib::Response& response) {
  const FlightRow flight = ExistingFlight(service, call);
  nlohmann::json features = nlohmann::json::array();
  for (const RegionRow& region : service.storage.flights.ListRegions(flight.id)) {
    features.push_back(nlohmann::json::parse(region.feature_json));
  }
  AnswerGeoJson({{"type", "FeatureCollection"}, {"features", std::move(features)}}, response);
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

// The rank of a site is its place in the whole list, also on a later page.
void GetSites(Service& service, const Call& call, httplib::Response& response) {
  const std::string order = call.Query("order").value_or("rank");
  if (order == "new_look") return GetSitesByNewLook(service, call, response);
  if (order != "rank") {
    const std::string detail = "order: must be rank or new_look";
    throw ApiError("InvalidQuery", detail, {{"order", detail}});
  }
  const std::optional<BoundingBox> box = ParseBoundingBox(call);
  const size_t limit = ParseLimit(call);
  const std::optional<RankKey> after = ParseRankCursor(call);
  const std::vector<SiteRow> sites = ListedSites(service, call, std::nullopt, box);
  const std::vector<RankedRow> ranked = Ranked(sites);
  const auto is_up_to = [](const RankKey& key, const RankedRow& row) { return key < row.key; };
  const auto first =
      after ? std::upper_bound(ranked.begin(), ranked.end(), *after, is_up_to) : ranked.begin();
  const auto end = first + static_cast<std::ptrdiff_t>(
                               std::min(limit, static_cast<size_t>(ranked.end() - first)));
  std::string features;
  const int64_t now_us = NowUs();
  for (auto row = first; row != end; ++row) {
    nlohmann::json feature = FeatureOf(*row->row, now_us);
    feature["properties"]["rank"] = row - ranked.begin() + 1;
    features += (row == first ? "" : ",") + feature.dump();
  }
  std::optional<std::string> next;
  if (end != ranked.end()) next = CursorOf((end - 1)->key);
  AnswerFeatures(features, next, response);
}

// Answers the site with its rank in its flight.
void GetSite(Service& service, const Call& call, httplib::Response& response) {
  const SiteRow site = ExistingSite(service, call);
  const auto ranked = RankedSites(FeaturesOf(SitesOfFlight(service, site.flight_id)));
  for (const nlohmann::json& feature : ranked["features"]) {
    if (feature["properties"]["id"] == site.id) response.set_content(feature.dump(), kGeoJson);
  }
}

void DeleteSite(Service& service, const Call& call, httplib::Response& response) {
  if (!ForgetSite(service.storage, service.maps, ExistingSite(service, call).id)) {
    throw ApiError("NoSuchSite", "there is no such site");
  }
  service.alternates.WakeAll();
  response.status = 204;
}

}  // namespace freelsd
