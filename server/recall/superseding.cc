#include "server/recall/superseding.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include <spdlog/spdlog.h>

#include "server/recall/plan_check.h"
#include "server/recall/recall_sites.h"

namespace freelsd {
namespace {

// About 2 km. No plan reaches farther from its touchdown.
constexpr double kReachDeg = 0.02;

// The map of a site that is about to be stored, before storage has it.
struct NewMap {
  const SiteRow& site;
  GeoPoint origin;
  SiteMap site_map;
};

BoundingBox Widened(const BoundingBox& box) {
  return {std::remainder(box.west_deg - kReachDeg, 360.0),
          box.south_deg - kReachDeg,
          std::remainder(box.east_deg + kReachDeg, 360.0),
          box.north_deg + kReachDeg};
}

// Of the maps on which the plan fails, the newest one supersedes the site. Of the maps on which it
// holds, the newest one confirms the site. The order of the checks therefore does not matter.
Standing With(Standing standing,
              const PlanCheck& check,
              const std::string& site_id,
              int64_t seen_at_us) {
  if (check.verdict == PlanVerdict::kHolds) {
    standing.confirmed_at_us = std::max(standing.confirmed_at_us.value_or(seen_at_us), seen_at_us);
  }
  if (check.verdict != PlanVerdict::kFails) return standing;
  const bool is_newest =
      !standing.superseded_by ||
      std::tie(standing.superseded_at_us, *standing.superseded_by) < std::tie(seen_at_us, site_id);
  if (!is_newest) return standing;
  standing.superseded_by = site_id;
  standing.superseded_at_us = seen_at_us;
  standing.superseded_reason = check.reason;
  standing.superseded_detail = check.detail;
  return standing;
}

// Photographs from the same time show the same ground. A flight that was sent twice therefore
// changes nothing.
bool IsLater(const std::string& flight_id, int64_t seen_at_us, const SiteRow& site) {
  return flight_id != site.flight_id && seen_at_us > site.seen_at_us;
}

Standing OnNewMap(Standing standing,
                  const SiteRow& site,
                  const StoredPlan& plan,
                  const NewMap& added) {
  const SiteRow& newer = added.site;
  if (!IsLater(newer.flight_id, newer.seen_at_us, site)) return standing;
  return With(std::move(standing),
              CheckPlan(plan, added.origin, added.site_map),
              newer.id,
              newer.seen_at_us);
}

// Checks the site on all stored maps except that of `changed_id`, and on the new map.
Standing StandingOf(const StoredSites& stored,
                    const SiteRow& site,
                    const std::string& changed_id,
                    const std::optional<NewMap>& added) {
  Standing standing;
  standing.is_checked = true;
  const std::optional<StoredPlan> plan = ReadStoredPlan(site);
  if (!plan) return standing;
  for (const auto& row : stored.storage.sites.ListMaps(BoxOf(*plan))) {
    if (row->site_id == changed_id || !IsLater(row->flight_id, row->seen_at_us, site)) continue;
    const auto kept = stored.maps.Get(stored.storage, row->site_id, row->updated_at_us);
    if (!kept) continue;
    standing = With(std::move(standing),
                    CheckPlan(*plan, kept->replan.origin, kept->site_map),
                    row->site_id,
                    row->seen_at_us);
  }
  return added ? OnNewMap(std::move(standing), site, *plan, *added) : standing;
}

// New standings of the sites whose standing depended on the old map of `changed_id`.
Standings OfDependents(const StoredSites& stored,
                       const std::string& changed_id,
                       const std::optional<NewMap>& added) {
  Standings standings;
  for (const std::string& id : stored.storage.sites.ListDependents(changed_id)) {
    const std::optional<SiteRow> site = stored.storage.sites.Find(id);
    if (!site || id == changed_id) continue;
    standings.emplace_back(id, StandingOf(stored, *site, changed_id, added));
  }
  return standings;
}

// Adds earlier sites that the new map changes.
Standings WithEarlier(const StoredSites& stored, Standings standings, const NewMap& added) {
  const SiteRow& newer = added.site;
  const BoundingBox touchdown{
      newer.longitude_deg, newer.latitude_deg, newer.longitude_deg, newer.latitude_deg};
  for (const auto& row :
       stored.storage.sites.ListMaps(Widened(newer.map_box.value_or(touchdown)))) {
    const bool is_known =
        std::any_of(standings.begin(), standings.end(), [&row](const auto& standing) {
          return standing.first == row->site_id;
        });
    if (is_known || !row->is_recallable || row->flight_id == newer.flight_id ||
        row->seen_at_us >= newer.seen_at_us) {
      continue;
    }
    const std::optional<SiteRow> site = stored.storage.sites.Find(row->site_id);
    if (!site) continue;
    const std::optional<StoredPlan> plan = ReadStoredPlan(*site);
    if (!plan) continue;
    const Standing& before = *site;
    Standing after = before.is_checked ? OnNewMap(before, *site, *plan, added)
                                       : StandingOf(stored, *site, newer.id, added);
    if (!(after == before)) standings.emplace_back(row->site_id, std::move(after));
  }
  return standings;
}

std::optional<NewMap> NewMapOf(const SiteRow& site, const std::string& map_blob) {
  if (map_blob.empty()) return std::nullopt;
  return NewMap{site, ParseReplan(site.replan_json).origin, DeserializeSiteMap(map_blob)};
}

void Report(MapCache& maps, const std::string& site_id, const Standing& standing) {
  if (!standing.superseded_by) return;
  maps.DropPlans(site_id);
  spdlog::info("site {} is superseded by {}: {}: {}",
               site_id,
               *standing.superseded_by,
               standing.superseded_reason,
               standing.superseded_detail);
}

}  // namespace

void StoreSite(Storage& storage, MapCache& maps, SiteRow site, const std::string& map_blob) {
  const StoredSites stored{storage, maps};
  static_cast<Standing&>(site) = StandingOf(stored, site, site.id, std::nullopt);
  const std::optional<NewMap> added = NewMapOf(site, map_blob);
  Standings others = OfDependents(stored, site.id, added);
  if (added) others = WithEarlier(stored, std::move(others), *added);
  storage.sites.Put(site, map_blob, others);
  Report(maps, site.id, site);
  for (const auto& [id, standing] : others) Report(maps, id, standing);
}

bool ForgetSite(Storage& storage, MapCache& maps, const std::string& site_id) {
  const StoredSites stored{storage, maps};
  return storage.sites.Delete(site_id, OfDependents(stored, site_id, std::nullopt));
}

void CheckUnchecked(Storage& storage, MapCache& maps, const std::string& site_id) {
  const std::optional<SiteRow> site = storage.sites.Find(site_id);
  if (!site || site->is_checked) return;
  const Standing standing = StandingOf({storage, maps}, *site, site_id, std::nullopt);
  storage.sites.SetStandings({{site_id, standing}});
  Report(maps, site_id, standing);
}

}  // namespace freelsd
