#include "server/recall/own_sites.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "server/recall/plan_check.h"

namespace freelsd {
namespace {

RecallRow RecalledRowOf(const SiteRow& site, const StoredPlan& plan) {
  RecallRow row;
  row.site_id = site.id;
  row.flight_id = site.flight_id;
  row.map_id = site.map_id;
  row.latitude_deg = site.latitude_deg;
  row.longitude_deg = site.longitude_deg;
  row.updated_at_us = site.updated_at_us;
  row.seen_at_us = site.LastSeenUs();
  row.seen_until_us = site.seen_until_us;
  row.data = {plan.site.verdict == "landable",
              plan.site.touchdown.altitude_m,
              plan.site.altitude_datum,
              plan.site.score.value_or(0.0),
              AircraftJson(plan.replan.flight.aircraft).dump()};
  if (site.IsDoubted()) row.doubt = std::make_shared<const Standing>(site);
  return row;
}

}  // namespace

SiteRow AsRemembered(SiteRow site, const FlightMemory& memory) {
  if (memory.is_kept) return site;
  site.recall.reset();
  nlohmann::json feature = nlohmann::json::parse(site.feature_json);
  nlohmann::json& properties = feature["properties"];
  properties["memory"] = NameOf(memory);
  properties["warnings"].push_back(kExperimentWarning);
  properties["summary"] = properties.value("summary", "") + " " + kExperimentWarning;
  site.feature_json = feature.dump();
  return site;
}

bool IsOwnExperiment(const EmergencyRequest& request, const RecallRow& site) {
  return request.is_of_experiment && request.flight_id == site.flight_id;
}

SharedRows<RecallRow> OwnSites(const Storage& storage, const EmergencyRequest& request) {
  SharedRows<RecallRow> rows;
  if (!request.is_of_experiment) return rows;
  for (const SiteRow& site : storage.sites.List(request.flight_id, std::nullopt)) {
    if (site.superseded_by) continue;
    const std::optional<StoredPlan> plan = ReadStoredPlan(site);
    if (plan) rows.push_back(std::make_shared<const RecallRow>(RecalledRowOf(site, *plan)));
  }
  return rows;
}

RecallBounds WithSites(RecallBounds bounds, const SharedRows<RecallRow>& sites) {
  std::vector<std::string>& aircraft = bounds.aircraft_jsons;
  for (const auto& site : sites) {
    const bool is_first = aircraft.empty();
    const double altitude_m = site->data.altitude_m;
    bounds.min_altitude_m = is_first ? altitude_m : std::min(bounds.min_altitude_m, altitude_m);
    const std::string& json = site->data.aircraft_json;
    if (std::find(aircraft.begin(), aircraft.end(), json) == aircraft.end()) {
      aircraft.push_back(json);
    }
  }
  return bounds;
}

}  // namespace freelsd
