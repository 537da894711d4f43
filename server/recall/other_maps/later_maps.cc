#include <algorithm>
#include <utility>

#include "server/recall/other_maps/other_maps.h"

namespace freelsd {
namespace {

std::optional<PlanCheck> CheckOnFlightMap(const StoredSites& stored,
                                          const StoredPlan& plan,
                                          const std::string& map_id) {
  FlightMaps& maps = stored.maps.flight_maps();
  const auto map = maps.Find(stored.storage, map_id);
  if (!map) return std::nullopt;
  const MapHead& head = map->head;
  const Polygon ground = CheckedGroundOf(plan, head.origin, head.grid, head.position_sd_m);
  const Grid grid = head.grid.Part(head.grid.CellsAround(ground, 0.0));
  if (grid.num_rows == 0 || grid.num_cols == 0) return std::nullopt;
  const MapRasters rasters = maps.Read(stored.storage, *map, 0, grid, TileLayers::kPlanning);
  return CheckPlan(plan, head.origin, rasters.site_map);
}

}  // namespace

SharedRows<MapRow> MapsOfOthers(const Storage& storage,
                                const std::string& flight_id,
                                const BoundingBox& box) {
  SharedRows<MapRow> rows = storage.sites.ListMaps(box);
  std::erase_if(rows, [&flight_id](const auto& row) { return row->flight_id == flight_id; });
  std::sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a->id < b->id; });
  return rows;
}

bool HasLaterMaps(const KeptSite& site) {
  return std::any_of(site.other_maps.begin(), site.other_maps.end(), [&site](const auto& map) {
    return MayBeLater(*map, site.row);
  });
}

std::optional<PlanCheck> CheckPlanOn(const StoredSites& stored,
                                     const StoredPlan& plan,
                                     const MapRow& map) {
  if (map.is_of_flight) return CheckOnFlightMap(stored, plan, map.id);
  const auto kept = stored.maps.Get(stored.storage, map.id, map.updated_at_us);
  if (!kept) return std::nullopt;
  return CheckPlan(plan, kept->replan.origin, kept->site_map);
}

Plan CheckedAround(Plan plan,
                   const StoredSites& stored,
                   const KeptSite& site,
                   const Aircraft& aircraft,
                   const std::optional<Eigen::Vector2d>& wind_in_world) {
  plan = CheckedBeyondMap(std::move(plan), site.obstructed_map.map, aircraft, site.obstacles, {});
  if (plan.verdict == Verdict::kRejected || !plan.approach || !HasLaterMaps(site)) return plan;
  Replan replan = site.replan;
  replan.flight.aircraft = aircraft;
  replan.request.wind_in_world = wind_in_world;
  const StoredPlan as_stored = AsStoredPlan(plan, std::move(replan));
  for (const auto& map : site.other_maps) {
    if (!MayBeLater(*map, site.row)) continue;
    const auto check = CheckPlanOn(stored, as_stored, *map);
    if (!check || check->verdict != PlanVerdict::kFails) continue;
    plan.verdict = Verdict::kRejected;
    plan.reject_reason = check->reason;
    plan.reject_detail = OnOtherMap(map->flight_id, IsLater(*map, site.row)) + check->detail;
    break;
  }
  return plan;
}

void CheckAround(const StoredSites& stored,
                 const KeptSite& site,
                 const Aircraft& aircraft,
                 const std::optional<Eigen::Vector2d>& wind_in_world,
                 PlaceJudgement& judgement) {
  if (judgement.verdict == Verdict::kRejected || !judgement.plan) return;
  const Plan plan = CheckedAround(*judgement.plan, stored, site, aircraft, wind_in_world);
  PlaceRule rule{.name = "surroundings",
                 .passed = plan.verdict != Verdict::kRejected,
                 .sentence = "No obstacle beyond the map and no later map breaks a rule."};
  if (!rule.passed) {
    judgement.verdict = Verdict::kRejected;
    rule.sentence = "The landing fails here: " + plan.reject_detail + ".";
  }
  // What leaves a place unverified comes last.
  const auto last =
      std::find_if(judgement.rules.begin(), judgement.rules.end(), [](const PlaceRule& each) {
        return each.name == "circle_seen" || each.name == "wind_known";
      });
  judgement.rules.insert(last, std::move(rule));
}

}  // namespace freelsd
