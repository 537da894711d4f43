#include <algorithm>
#include <utility>

#include "api/export/layers/layers.h"
#include "server/recall/other_maps/other_maps.h"

namespace freelsd {
namespace {

std::optional<ShownGround> GroundOnFlightMap(const StoredSites& stored,
                                             const StoredPlan& plan,
                                             const FlightMap& map,
                                             TileLayers layers) {
  const MapHead& head = map.head;
  const Polygon ground = CheckedGroundOf(plan, head.origin, head.grid, head.position_sd_m);
  const Grid grid = head.grid.Part(head.grid.CellsAround(ground, 0.0));
  if (grid.num_rows == 0 || grid.num_cols == 0) return std::nullopt;
  return ShownGround{head.origin,
                     stored.maps.flight_maps().Read(stored.storage, map, 0, grid, layers)};
}

ShownGround GroundUnder(const StoredPlan& plan, const GeoPoint& origin, const SiteMap& map) {
  const double position_sd_m = map.map.position_sd_m;
  const Polygon ground = CheckedGroundOf(plan, origin, map.map.grid, position_sd_m);
  return {origin, {CropAround(map.map, map.layers, ground, 0.0), {}}};
}

// Experiments judge no site of another flight, nor do flights with an aircraft that allows more
// than every profile does.
bool IsJudge(const FlightMemory& memory, const Aircraft& aircraft) {
  return memory.is_kept && LimitsLooserThanProfiles(aircraft).empty();
}

// Nothing if the map cannot be read, is no judge, or does not show the ground.
std::optional<ShownGround> GroundOn(const StoredSites& stored,
                                    const StoredPlan& plan,
                                    const MapRow& map,
                                    TileLayers layers) {
  const auto found = stored.maps.flight_maps().Find(stored.storage, map.id);
  if (!found || !IsJudge(found->memory, found->aircraft)) return std::nullopt;
  return GroundOnFlightMap(stored, plan, *found, layers);
}

// Of a plan that breaks a rule on the later map.
PlanCheck Judged(const StoredPlan& plan,
                 const PlanCheck& failure,
                 const OwnGround& own,
                 const ShownGround& later) {
  const std::optional<ShownGround> ground = own();
  if (ground) {
    if (auto broken = BrokenByEvidence(plan, *ground, later, {})) return *std::move(broken);
  }
  return {PlanVerdict::kDoubts, failure.reason, failure.detail};
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
                                     const MapRow& map,
                                     const OwnGround& own) {
  const auto shown = GroundOn(stored, plan, map, TileLayers::kPlanning);
  if (!shown) return std::nullopt;
  const PlanCheck check = CheckPlan(plan, shown->origin, shown->rasters.site_map);
  if (check.verdict != PlanVerdict::kFails) return check;
  const auto with_cues = GroundOn(stored, plan, map, TileLayers::kWithCues);
  return Judged(plan, check, own, with_cues.value_or(*shown));
}

std::optional<ShownGround> OwnGroundOf(const StoredSites& stored,
                                       const SiteRow& site,
                                       const StoredPlan& plan) {
  const auto map = stored.maps.flight_maps().Find(stored.storage, site.map_id);
  if (!map) return std::nullopt;
  return GroundOnFlightMap(stored, plan, *map, TileLayers::kPlanning);
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
  const OwnGround own = [&] { return GroundUnder(as_stored, site.replan.origin, site.site_map); };
  for (const auto& map : site.other_maps) {
    if (!MayBeLater(*map, site.row)) continue;
    const auto check = CheckPlanOn(stored, as_stored, *map, own);
    if (!check) continue;
    const std::string on_map = OnOtherMap(map->flight_id, IsLater(*map, site.row));
    if (check->verdict == PlanVerdict::kDoubts) {
      plan.verdict = Verdict::kUnverified;
      plan.reject_detail = on_map + "the ground is not recognised as fit: " + check->detail;
    }
    if (check->verdict != PlanVerdict::kFails) continue;
    plan.verdict = Verdict::kRejected;
    plan.reject_reason = check->reason;
    plan.reject_detail = on_map + check->detail;
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
                 .passed = plan.reject_detail.empty(),
                 .sentence = "No obstacle beyond the map and no later map breaks a rule."};
  if (!rule.passed) {
    judgement.verdict = plan.verdict;
    rule.sentence = (plan.verdict == Verdict::kRejected ? "The landing fails here: "
                                                        : "The landing is not sure: ") +
                    plan.reject_detail + ".";
  }
  // What leaves a place unverified comes last.
  const auto last =
      std::find_if(judgement.rules.begin(), judgement.rules.end(), [](const PlaceRule& each) {
        return each.name == "circle_seen" || each.name == "wind_known";
      });
  judgement.rules.insert(last, std::move(rule));
}

}  // namespace freelsd
