#include "server/jobs/sites/sites.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/stored/stored.h"
#include "server/http/http.h"
#include "server/jobs/evidence/evidence.h"
#include "server/jobs/staged_maps.h"

namespace freelsd {
namespace {

Replan ReplanOf(const Site& site, const EvaluatedFlight& flight) {
  Replan replan;
  replan.flight = flight.request;
  replan.origin = flight.origin;
  replan.request.footprint = site.region.Footprint();
  replan.request.area_m2 = site.region.area_m2;
  replan.request.grade = site.region.grade;
  replan.request.num_observations = site.region.num_observations;
  replan.request.min_num_observations = flight.min_num_observations;
  if (site.wind) {
    replan.request.wind_in_world = site.wind->wind_in_world;
    replan.request.wind_spread_mps = site.wind->spread_mps;
  }
  return replan;
}

std::optional<RecallData> RecallOf(const Site& site,
                                   const FlightRequest& request,
                                   double altitude) {
  const Plan& plan = site.plan;
  if (plan.verdict == Verdict::kRejected || !plan.approach) return std::nullopt;
  if (!std::isfinite(altitude)) return std::nullopt;
  return RecallData{plan.verdict == Verdict::kLandable,
                    altitude,
                    request.altitude_datum.value_or("unknown"),
                    std::clamp(plan.score, 0.0, 1.0),
                    AircraftJson(request.aircraft).dump()};
}

// A site that only obstacles reject is stored with its plan without them. Whoever reads the site
// checks the plan against the obstacles of that time (AsObstructed), so that it is rejected for as
// long as they are there.
Site AsStored(Site site) {
  if (site.plan_without_obstacles) site.plan = *std::exchange(site.plan_without_obstacles, {});
  return site;
}

// Of a region, or of a square of the flight's world: stable while its ground is.
std::string NameWithin(const Site& site) {
  if (!site.square) return "-r" + std::to_string(site.region.id);
  return "-e" + std::to_string(site.square->east) + "n" + std::to_string(site.square->north);
}

// If nothing was reconstructed, the last photograph of the region counts.
CaptureTime WhenSeen(const Site& site, const AdjustedBlock& block, const CaptureTimes& times) {
  const auto last = times.find(site.region.last_seen_frame_id);
  if (block.views.empty() && last != times.end()) return last->second;
  return SeenAt(block, times, site.plan.touchdown_in_world);
}

NewSite SiteOf(const Site& site,
               const Evaluation& evaluation,
               const SiteOrigin& origin,
               const EvaluatedFlight& flight) {
  const Grid& grid = evaluation.map.grid;
  const FlightContext& context = flight.context;
  const FlightRequest& request = flight.request;
  NewSite made;
  made.row.id = context.flight_id + NameWithin(site);
  made.row.flight_id = context.flight_id;
  made.row.region_id = site.region.id;
  made.row.updated_at_us = NowUs();
  const GeoPoint touchdown = context.local_frame.GeoFromWorld(site.plan.touchdown_in_world);
  made.row.latitude_deg = touchdown.latitude_deg;
  made.row.longitude_deg = touchdown.longitude_deg;
  const std::string updated_at = Rfc3339(made.row.updated_at_us);
  const CaptureTime seen = WhenSeen(site, evaluation.block, flight.times);
  made.row.seen_at_us = seen.earliest_us;
  made.row.seen_until_us = SeenUntil(seen, made.row.updated_at_us);
  nlohmann::json feature = SiteFeature(made.row.id, site, request.aircraft, updated_at, context);
  feature["properties"]["last_seen_at"] = nullptr;
  if (seen.IsDated()) feature["properties"]["last_seen_at"] = Rfc3339(seen.earliest_us);
  if (site.plan.approach) made.row.approach_json = ApproachJson(site.plan, context).dump();
  made.digest = EvidenceDigest(
      origin.inputs_digest, origin.map_digest, NameWithin(site), feature, made.row.approach_json);
  feature["properties"]["evidence_digest"] = made.digest;
  made.row.feature_json = feature.dump();
  made.row.replan_json = ReplanJson(ReplanOf(site, flight));
  made.row.map_datum = context.altitude_datum;
  made.row.recall = RecallOf(site, request, touchdown.altitude_m);
  if (made.row.recall) {
    const auto wind = site.wind ? std::optional(site.wind->wind_in_world) : std::nullopt;
    made.landing = LandingOf(touchdown, site.plan.approach->heading, wind);
  }
  if (!origin.map_id.empty()) {
    made.row.map_id = origin.map_id;
    const Grid around = grid.Part(
        grid.CellsAround(site.region.Footprint(), request.options.backend.max_surroundings_m));
    if (around.num_rows > 0) made.row.map_box = BoxOf(around, context.local_frame);
  }
  return made;
}

}  // namespace

std::vector<NewSite> SitesOf(const Evaluation& evaluation,
                             const SiteOrigin& origin,
                             const EvaluatedFlight& flight) {
  std::vector<NewSite> sites;
  for (const Site& site : evaluation.sites) {
    sites.push_back(SiteOf(AsStored(site), evaluation, origin, flight));
  }
  return sites;
}

void DropDuplicates(std::vector<NewSite>& sites) {
  const auto key = [](const NewSite& site) {
    const bool is_landable = site.row.recall && site.row.recall->is_landable;
    return std::tuple(!is_landable, site.row.recall ? -site.row.recall->score : 0.0, site.row.id);
  };
  std::sort(sites.begin(), sites.end(), [&key](const NewSite& a, const NewSite& b) {
    return key(a) < key(b);
  });
  std::vector<NewSite> kept;
  for (NewSite& site : sites) {
    const bool is_known = std::any_of(kept.begin(), kept.end(), [&](const auto& better) {
      if (better.row.id == site.row.id) return true;
      return better.landing && site.landing && IsSamePlace(*better.landing, *site.landing);
    });
    if (!is_known) kept.push_back(std::move(site));
  }
  sites = std::move(kept);
}

}  // namespace freelsd
