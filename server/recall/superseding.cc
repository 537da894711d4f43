#include "server/recall/superseding.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include <nlohmann/json.hpp>

#include "server/recall/obstacles/obstacles.h"
#include "server/recall/other_maps/other_maps.h"
#include "server/recall/plan_check.h"
#include "server/recall/recall_sites.h"
#include "server/recall/standing.h"

namespace freelsd {
namespace {

// The box, so much larger on each side. Longitudes may leave [-180, 180].
BoundingBox Widened(const BoundingBox& box, double reach_m) {
  const double dlat_deg = reach_m / kMetresPerDegree;
  const double far_deg = std::max(std::abs(box.south_deg), std::abs(box.north_deg)) + dlat_deg;
  const double dlon_deg = dlat_deg / std::cos(RadFromDeg(std::min(far_deg, 89.5)));
  return {box.west_deg - dlon_deg,
          box.south_deg - dlat_deg,
          box.east_deg + dlon_deg,
          box.north_deg + dlat_deg};
}

// What is about to change: the checks see it as if it were stored already.
struct Change {
  // Maps that do not count any more.
  std::set<std::string> gone_maps;
  std::set<std::string> gone_sites;
  // New maps of a flight, staged in storage, and the flight's sites on them.
  std::vector<FlightMapRow> new_maps;
  std::vector<SiteRow> new_sites;
};

class Checks {
 public:
  Checks(const StoredSites& stored, const Change& change) : stored_(stored), change_(change) {}

  // Checks the site on all maps that will be stored.
  Standing StandingOf(const SiteRow& site) const {
    Standing standing;
    const std::optional<StoredPlan> plan = ReadStoredPlan(site);
    if (!plan) return standing;
    for (const auto& row : stored_.storage.sites.ListMaps(BoxOf(*plan))) {
      if (change_.gone_maps.contains(row->id)) continue;
      standing = OnMap(std::move(standing), site, *plan, *row);
    }
    return OnNewMaps(std::move(standing), site, *plan);
  }

  // The standing of a site that storage has, with what the new maps change.
  Standing Renewed(const SiteRow& site) const {
    const std::optional<StoredPlan> plan = ReadStoredPlan(site);
    if (!plan) return site;
    return OnNewMaps(site, site, *plan);
  }

 private:
  Standing OnNewMaps(Standing standing, const SiteRow& site, const StoredPlan& plan) const {
    for (const FlightMapRow& map : change_.new_maps) {
      standing = OnMap(std::move(standing), site, plan, RowOf(map));
    }
    return standing;
  }

  OwnGround OwnGroundUnder(const SiteRow& site, const StoredPlan& plan) const {
    return [this, &site, &plan] { return OwnGroundOf(stored_, site, plan); };
  }

  Standing OnMap(Standing standing,
                 const SiteRow& site,
                 const StoredPlan& plan,
                 const MapRow& map) const {
    if (!MayBeLater(map, site)) return standing;
    const auto check = CheckPlanOn(stored_, plan, map, OwnGroundUnder(site, plan));
    if (!check) return standing;
    return WithCheck(std::move(standing), *check, site, map, ShownId(map, plan.site.touchdown));
  }

  // A map confirms a site only if it is later than all of the map that the site lies on.
  Standing WithCheck(Standing standing,
                     const PlanCheck& check,
                     const SiteRow& site,
                     const MapRow& map,
                     const std::string& shown_id) const {
    const bool is_confirmed = check.verdict == PlanVerdict::kHolds;
    if (is_confirmed && !IsLaterThanMap(stored_, map, site)) return standing;
    return With(std::move(standing), check, map, shown_id, IsLater(map, site));
  }

  // The site of the map that is nearest to the place, else the flight.
  std::string ShownId(const MapRow& map, const GeoPoint& place) const {
    const LocalFrame frame(place);
    std::string nearest = map.flight_id;
    double least = std::numeric_limits<double>::infinity();
    const auto look_at = [&](const SiteRow& site) {
      if (site.map_id != map.id || change_.gone_sites.contains(site.id)) return;
      const double distance =
          frame.WorldFromGeo({site.latitude_deg, site.longitude_deg, place.altitude_m})
              .head<2>()
              .norm();
      if (std::tie(distance, site.id) >= std::tie(least, nearest)) return;
      least = distance;
      nearest = site.id;
    };
    for (const SiteRow& site : change_.new_sites) look_at(site);
    for (const SiteRow& site : stored_.storage.sites.List(map.flight_id, std::nullopt)) {
      look_at(site);
    }
    return nearest;
  }

  const StoredSites& stored_;
  const Change& change_;
};

// Of stored sites that stay, by id.
class NewStandings {
 public:
  NewStandings(const StoredSites& stored, const Change& change)
      : stored_(stored), change_(change), checks_(stored, change) {}

  // New standings of sites that depend on what will be gone.
  void AddDependents(const std::vector<std::string>& ids) {
    for (const std::string& id : ids) {
      const std::optional<SiteRow> site = FindKept(id);
      if (site) standings_.emplace_back(id, checks_.StandingOf(*site));
    }
  }

  // Earlier sites of other flights, around a new map; those of `among`, if it is given.
  void AddEarlier(const BoundingBox& box,
                  const std::string& flight_id,
                  const std::set<std::string>* among = nullptr) {
    const SiteStore& sites = stored_.storage.sites;
    const double reach_m = ReachOfPlans(sites.BoundsOfRecallable());
    for (const std::string& id : sites.ListAccepted(Widened(box, reach_m))) {
      if (among != nullptr && !among->contains(id)) continue;
      const std::optional<SiteRow> site = FindKept(id);
      if (!site || site->flight_id == flight_id) continue;
      Standing after = checks_.Renewed(*site);
      const Standing& before = *site;
      if (!(after == before)) standings_.emplace_back(id, std::move(after));
    }
  }

  const Standings& standings() const { return standings_; }

 private:
  // Nothing if the site will be gone, is new, or has its standing already.
  std::optional<SiteRow> FindKept(const std::string& id) const {
    const bool is_known = std::any_of(standings_.begin(),
                                      standings_.end(),
                                      [&id](const auto& standing) { return standing.first == id; });
    const bool is_new = std::any_of(change_.new_sites.begin(),
                                    change_.new_sites.end(),
                                    [&id](const SiteRow& site) { return site.id == id; });
    if (is_known || is_new || change_.gone_sites.contains(id)) return std::nullopt;
    return stored_.storage.sites.Find(id);
  }

  const StoredSites& stored_;
  const Change& change_;
  const Checks checks_;
  Standings standings_;
};

std::vector<FlightMapRow> MapsOf(const Storage& storage, const std::vector<std::string>& ids) {
  std::vector<FlightMapRow> maps;
  for (const std::string& id : ids) {
    if (std::optional<FlightMapRow> map = storage.maps.Find(id)) maps.push_back(*std::move(map));
  }
  return maps;
}

Change ChangeOf(const Storage& storage, const EvaluationRows& rows) {
  Change change;
  change.gone_maps.insert(rows.forgotten_maps.begin(), rows.forgotten_maps.end());
  change.gone_sites.insert(rows.forgotten_sites.begin(), rows.forgotten_sites.end());
  change.new_sites = rows.sites;
  change.new_maps = MapsOf(storage, rows.new_maps);
  return change;
}

// New standings of sites that the followed server does not know.
Standings UnknownStandings(const StoredSites& stored,
                           const Change& change,
                           const UnknownAbove& unknown) {
  NewStandings standings(stored, change);
  if (unknown.sites.empty()) return {};
  const auto add = [&](std::vector<std::string> dependents) {
    std::erase_if(dependents, [&](const auto& site) { return !unknown.sites.contains(site); });
    standings.AddDependents(dependents);
  };
  const SiteStore& sites = stored.storage.sites;
  for (const std::string& id : change.gone_sites) add(sites.ListDependents(id));
  for (const std::string& id : change.gone_maps) add(sites.ListDependentsOfMap(id));
  for (const FlightMapRow& map : change.new_maps) {
    standings.AddEarlier(map.box, map.flight_id, &unknown.sites);
  }
  return standings.standings();
}

}  // namespace

void StoreFollowed(Storage& storage,
                   MapCache& maps,
                   SiteTurn& turn,
                   EvaluationRows rows,
                   const Standings& told,
                   const UnknownAbove& unknown) {
  const StoredSites stored{storage, maps};
  Change own;
  own.new_maps = unknown.maps;
  const Checks checks(stored, own);
  Standings others;
  for (SiteRow& site : rows.sites) {
    Standing standing = checks.Renewed(site);
    if (!(standing == static_cast<const Standing&>(site))) {
      rows.sites_unknown_above.push_back(site.id);
    }
    static_cast<Standing&>(site) = std::move(standing);
  }
  for (const auto& [id, told_standing] : told) {
    std::optional<SiteRow> site = storage.sites.Find(id);
    if (!site) continue;
    static_cast<Standing&>(*site) = told_standing;
    others.emplace_back(id, checks.Renewed(*site));
    if (!(others.back().second == told_standing)) rows.sites_unknown_above.push_back(id);
  }
  const Change change = ChangeOf(storage, rows);
  for (auto& [id, standing] : UnknownStandings(stored, change, unknown)) {
    rows.sites_unknown_above.push_back(id);
    others.emplace_back(id, std::move(standing));
  }
  turn.PutEvaluation(rows, others);
  ReportAll(maps, rows.sites, others);
}

void StoreEvaluation(Storage& storage, MapCache& maps, SiteTurn& turn, EvaluationRows rows) {
  const StoredSites stored{storage, maps};
  const Change change = ChangeOf(storage, rows);
  const Checks checks(stored, change);
  for (SiteRow& site : rows.sites) static_cast<Standing&>(site) = checks.StandingOf(site);
  NewStandings others(stored, change);
  for (const std::string& id : change.gone_sites) {
    others.AddDependents(storage.sites.ListDependents(id));
  }
  for (const std::string& id : change.gone_maps) {
    others.AddDependents(storage.sites.ListDependentsOfMap(id));
  }
  // What a map supersedes names the nearest site on it.
  for (const SiteRow& site : rows.sites) {
    others.AddDependents(storage.sites.ListDependents(site.id));
    if (!site.map_id.empty()) {
      others.AddDependents(storage.sites.ListDependentsOfMap(site.map_id));
    }
  }
  for (const FlightMapRow& map : change.new_maps) others.AddEarlier(map.box, map.flight_id);
  turn.PutEvaluation(rows, others.standings());
  ReportAll(maps, rows.sites, others.standings());
}

bool ForgetSite(Storage& storage, MapCache& maps, const std::string& site_id) {
  const std::unique_ptr<SiteTurn> turn = storage.sites.TakeTurn();
  const StoredSites stored{storage, maps};
  Change change;
  change.gone_sites.insert(site_id);
  NewStandings others(stored, change);
  others.AddDependents(storage.sites.ListDependents(site_id));
  return turn->Delete(site_id, others.standings());
}

bool ForgetFlight(Storage& storage, MapCache& maps, const std::string& flight_id) {
  const std::unique_ptr<SiteTurn> turn = storage.sites.TakeTurn();
  EvaluationRows rows;
  for (const SiteRow& site : storage.sites.List(flight_id, std::nullopt)) {
    rows.forgotten_sites.push_back(site.id);
  }
  for (const FlightMapRow& map : storage.maps.ListOf(flight_id)) {
    rows.forgotten_maps.push_back(map.id);
  }
  if (storage.flights.Find(flight_id)) rows.deleted_flight = flight_id;
  if (rows.forgotten_sites.empty() && rows.forgotten_maps.empty() && !rows.deleted_flight) {
    return false;
  }
  StoreEvaluation(storage, maps, *turn, std::move(rows));
  return true;
}

}  // namespace freelsd
