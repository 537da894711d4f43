#include "server/following/merging.h"

#include <algorithm>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "api/api.h"
#include "server/following/feed.h"
#include "server/following/later.h"
#include "server/http/http.h"

namespace freelsd {
namespace {

// What the change says, against what is stored under its key.
class Choices {
 public:
  explicit Choices(const Storage& storage) : storage_(storage) {}

  Choice Of(const ToldChange& told) const {
    const std::optional<ChangeRow> last = storage_.changes.Find(told.change.key);
    const bool is_here = last && !IsRemoval(last->kind);
    if (told.IsRemoval()) {
      if (!last) return Choice::kTake;
      if (is_here && told.change.kind == ChangeKind::kExpired && !HasExpired(told.change.key.id)) {
        return Choice::kKeep;
      }
      if (is_here) return last->stamp_us <= told.change.stamp_us ? Choice::kTake : Choice::kKeep;
      return last->stamp_us < told.change.stamp_us ? Choice::kTake : Choice::kSame;
    }
    if (last && !is_here) {
      // What had left, or was withdrawn, comes back as it was.
      const bool is_newer = told.change.stamp_us > last->stamp_us ||
                            (last->is_known_above && told.change.stamp_us == last->stamp_us);
      return is_newer ? Choice::kTake : Choice::kKeep;
    }
    return !is_here ? Choice::kTake : OfStored(told);
  }

  bool IsHere(const ChangeKey& key) const {
    const std::optional<ChangeRow> last = storage_.changes.Find(key);
    return last && !IsRemoval(last->kind);
  }
  bool IsMapHere(const std::string& id) const { return IsHere({ChangeSubject::kMap, id}); }

 private:
  // By this server's clock: that of the teller may be wrong.
  bool HasExpired(const std::string& obstacle_id) const {
    const std::optional<ObstacleRow> obstacle = storage_.obstacles.Find(obstacle_id);
    return !obstacle || (obstacle->expires_at_us && *obstacle->expires_at_us <= NowUs());
  }
  Choice OfStored(const ToldChange& told) const {
    const std::string& id = told.change.key.id;
    if (told.site) return Between(*told.site, storage_.sites.Find(id));
    if (told.obstacle) return Between(*told.obstacle, storage_.obstacles.Find(id));
    return Between(*told.map, storage_.maps.Find(id));
  }

  const Storage& storage_;
};

// A map that is staged with this stamp.
bool IsStaged(const Storage& storage, const FlightMapRow& told) {
  const std::optional<FlightMapRow> staged = storage.maps.Find(told.id);
  return staged && staged->updated_at_us == told.updated_at_us;
}

std::set<std::string> NewMapsIn(const std::vector<ToldChange>& changes) {
  std::set<std::string> ids;
  for (const ToldChange& told : changes) {
    if (told.map) ids.insert(told.map->id);
  }
  return ids;
}

void RefuseMissingMaps(const Storage& storage, const std::vector<ToldChange>& changes) {
  const Choices choices(storage);
  const std::set<std::string> new_maps = NewMapsIn(changes);
  std::vector<FieldError> missing;
  for (size_t i = 0; i < changes.size(); ++i) {
    const ToldChange& told = changes[i];
    if (choices.Of(told) != Choice::kTake) continue;
    const std::string pointer = "/changes/" + std::to_string(i);
    if (told.map && !IsStaged(storage, *told.map)) missing.push_back({pointer, told.map->id});
    if (!told.site || told.site->map_id.empty()) continue;
    const std::string& map_id = told.site->map_id;
    if (!choices.IsMapHere(map_id) && !new_maps.contains(map_id)) {
      missing.push_back({pointer, map_id});
    }
  }
  if (missing.empty()) return;
  throw ApiError("MapMissing", "maps are not here yet: PUT /v1/maps/{map} first", missing);
}

// Of changes that are taken: what becomes of sites and maps, and of obstacles.
struct Taken {
  EvaluationRows rows;
  ToldObstacles obstacles;
  std::vector<ChangeRow> changes;
};

// `through_us`: of an obstacle that has changed meanwhile, nothing is removed.
void TakeRemoval(const Choices& choices, const ChangeKey& key, int64_t through_us, Taken& taken) {
  if (!choices.IsHere(key)) return;
  switch (key.subject) {
    case ChangeSubject::kSite:
      taken.rows.forgotten_sites.push_back(key.id);
      break;
    case ChangeSubject::kMap:
      taken.rows.forgotten_maps.push_back(key.id);
      break;
    case ChangeSubject::kObstacle:
      taken.obstacles.removed.push_back({key.id, through_us});
      break;
  }
}

Taken TakenFromBelow(const Storage& storage, const std::vector<ToldChange>& changes) {
  const Choices choices(storage);
  Taken taken;
  for (const ToldChange& told : changes) {
    if (choices.Of(told) != Choice::kTake) continue;
    taken.changes.push_back(told.change);
    if (told.IsRemoval()) {
      TakeRemoval(choices, told.change.key, told.change.stamp_us, taken);
    } else if (told.site) {
      taken.rows.sites.push_back(*told.site);
    } else if (told.map) {
      taken.rows.new_maps.push_back(told.map->id);
    } else if (told.obstacle) {
      taken.obstacles.stored.push_back(*told.obstacle);
    }
  }
  return taken;
}

bool IsEmpty(const EvaluationRows& rows) {
  return rows.sites.empty() && rows.forgotten_sites.empty() && rows.new_maps.empty() &&
         rows.forgotten_maps.empty();
}

// Whether what is stored now is what was told.
bool IsAsTold(const Storage& storage, const ToldChange& told) {
  if (Choices(storage).Of(told) != Choice::kSame) return false;
  if (!told.site) return true;
  const std::optional<SiteRow> stored = storage.sites.Find(told.site->id);
  return stored && static_cast<const Standing&>(*stored) == *told.site;
}

std::vector<SiteRow> SitesOf(const std::vector<ToldChange>& changes) {
  std::vector<SiteRow> sites;
  for (const ToldChange& told : changes) {
    if (told.site) sites.push_back(*told.site);
  }
  return sites;
}

// Another version with the same stamp may be cached.
void DropPlans(MapCache& maps, const std::vector<SiteRow>& sites) {
  for (const SiteRow& site : sites) maps.DropPlans(site.id);
}

UnknownAbove UnknownAboveIn(const Storage& storage) {
  constexpr size_t kMaxNumUnknown = 100000;
  UnknownAbove unknown;
  for (const ChangeRow& change : storage.changes.ListUnknownAbove(kMaxNumUnknown)) {
    if (IsRemoval(change.kind)) continue;
    if (change.key.subject == ChangeSubject::kSite) unknown.sites.insert(change.key.id);
    if (change.key.subject != ChangeSubject::kMap) continue;
    if (auto map = storage.maps.Find(change.key.id)) unknown.maps.push_back(*std::move(map));
  }
  return unknown;
}

// Sorts what the followed server told.
class FromAbove {
 public:
  FromAbove(const Storage& storage, const std::vector<ToldChange>& changes)
      : storage_(storage), choices_(storage) {
    taken.rows.is_from_above = true;
    for (const ToldChange& told : changes) Add(told);
  }

  Taken taken;
  Standings standings;
  // All that is here now as it was told.
  std::vector<ChangeRow> as_told;
  // Stored already as told.
  std::vector<ChangeRow> same;

 private:
  void Add(const ToldChange& change) {
    if (change.has_left) return AddLeft(change);
    const Choice choice = choices_.Of(change);
    if (choice == Choice::kKeep) return;
    as_told.push_back(change.change);
    if (choice == Choice::kSame) return AddSame(change);
    if (change.IsRemoval()) {
      TakeRemoval(choices_, change.change.key, change.change.stamp_us, taken);
    } else if (change.site) {
      AddSite(change);
    } else if (change.map && IsStaged(storage_, *change.map)) {
      AddMap(change.map->id);
    } else if (change.obstacle) {
      taken.obstacles.stored.push_back(*change.obstacle);
    }
    taken.changes.push_back(change.change);
  }

  void AddMap(const std::string& id) {
    std::vector<std::string>& maps = taken.rows.new_maps;
    if (std::find(maps.begin(), maps.end(), id) == maps.end()) maps.push_back(id);
  }

  void AddSite(const ToldChange& told) {
    const SiteRow& site = *told.site;
    if (!site.map_id.empty() && !choices_.IsMapHere(site.map_id)) {
      if (!storage_.maps.Find(site.map_id)) {
        spdlog::warn("site {} is left out: its map {} is not here", site.id, site.map_id);
        return;
      }
      AddMap(site.map_id);
    }
    taken.rows.sites.push_back(site);
  }

  void AddSame(const ToldChange& told) {
    if (told.site) standings.emplace_back(told.site->id, *told.site);
    if (auto last = storage_.changes.Find(told.change.key)) same.push_back(*std::move(last));
  }

  // What this server has made stays.
  void AddLeft(const ToldChange& told) {
    const std::optional<ChangeRow> last = storage_.changes.Find(told.change.key);
    if (!last || !last->is_known_above) return;
    TakeRemoval(choices_, told.change.key, last->stamp_us, taken);
  }

  const Storage& storage_;
  const Choices choices_;
};

// In one turn, which ends with it: obstacles have turns of their own.
Taken TakeSites(Storage& storage, MapCache& maps, const std::vector<ToldChange>& changes) {
  const std::unique_ptr<SiteTurn> turn = storage.sites.TakeTurn();
  RefuseMissingMaps(storage, changes);
  Taken taken = TakenFromBelow(storage, changes);
  if (!IsEmpty(taken.rows)) StoreEvaluation(storage, maps, *turn, taken.rows);
  return taken;
}

// Only those that change anything.
Standings Changed(const Storage& storage, const Standings& standings) {
  Standings changed;
  for (const auto& [id, standing] : standings) {
    const std::optional<SiteRow> site = storage.sites.Find(id);
    if (site && !(static_cast<const Standing&>(*site) == standing)) {
      changed.emplace_back(id, standing);
    }
  }
  return changed;
}

}  // namespace

MergeResult MergeFromBelow(Storage& storage,
                           MapCache& maps,
                           const std::vector<ToldChange>& changes) {
  RefuseMissingMaps(storage, changes);
  MergeResult merged;
  const Taken before = TakenFromBelow(storage, changes);
  // First: no site is known without its obstacles.
  if (!before.obstacles.stored.empty()) storage.obstacles.Merge({before.obstacles.stored, {}});
  const Taken taken = TakeSites(storage, maps, changes);
  if (!taken.obstacles.removed.empty()) storage.obstacles.Merge({{}, taken.obstacles.removed});
  for (ChangeRow change : before.changes) {
    change.changed_at_us = NowUs();
    if (IsRemoval(change.kind)) storage.changes.PutRemoval(change);
  }
  storage.changes.SetOrigins(before.changes);
  merged.num_taken = static_cast<int64_t>(before.changes.size());
  merged.sites = SitesOf(changes);
  DropPlans(maps, merged.sites);
  std::vector<ChangeKey> repeated;
  for (const ToldChange& told : changes) {
    if (!IsAsTold(storage, told)) repeated.push_back(told.change.key);
  }
  if (!repeated.empty()) storage.changes.Repeat(repeated);
  return merged;
}

std::vector<std::string> MapsToFetch(const Storage& storage,
                                     const std::vector<ToldChange>& changes) {
  const Choices choices(storage);
  std::set<std::string> ids;
  for (const ToldChange& told : changes) {
    if (told.IsRemoval() || told.has_left || choices.Of(told) != Choice::kTake) continue;
    if (told.map && !IsStaged(storage, *told.map)) ids.insert(told.map->id);
    if (!told.site || told.site->map_id.empty()) continue;
    if (!storage.maps.Find(told.site->map_id)) ids.insert(told.site->map_id);
  }
  return {ids.begin(), ids.end()};
}

MergeResult MergeFromAbove(Storage& storage,
                           MapCache& maps,
                           const std::vector<ToldChange>& changes) {
  const std::unique_ptr<SiteTurn> turn = storage.sites.TakeTurn();
  FromAbove sorted(storage, changes);
  const Standings standings = Changed(storage, sorted.standings);
  Taken& taken = sorted.taken;
  ToldObstacles& obstacles = taken.obstacles;
  if (!obstacles.stored.empty()) storage.obstacles.Merge({obstacles.stored, {}, true});
  if (!IsEmpty(taken.rows) || !standings.empty()) {
    StoreFollowed(storage, maps, *turn, taken.rows, standings, UnknownAboveIn(storage));
  }
  if (!obstacles.removed.empty()) storage.obstacles.Merge({{}, obstacles.removed, true});
  std::erase_if(sorted.same, [&standings](const ChangeRow& same) {
    return same.key.subject == ChangeSubject::kSite &&
           std::any_of(standings.begin(), standings.end(), [&same](const auto& standing) {
             return standing.first == same.key.id;
           });
  });
  storage.changes.SetKnownAbove(sorted.same);
  storage.changes.SetOrigins(sorted.as_told);
  MergeResult merged{static_cast<int64_t>(taken.changes.size() + standings.size()),
                     SitesOf(changes)};
  DropPlans(maps, merged.sites);
  return merged;
}

void RemoveUntold(Storage& storage,
                  MapCache& maps,
                  const std::vector<ChangeKey>& told,
                  const BoundingBox& area) {
  constexpr size_t kAll = size_t{1} << 30;
  const std::set<ChangeKey> known(told.begin(), told.end());
  const std::unique_ptr<SiteTurn> turn = storage.sites.TakeTurn();
  std::set<ChangeKey> near;
  for (const ChangeRow& change : storage.changes.List(0, kAll, ChangeAreaOf(area)).changes) {
    near.insert(change.key);
  }
  Taken taken;
  taken.rows.is_from_above = true;
  const Choices choices(storage);
  for (const ChangeRow& change : storage.changes.List(0, kAll, std::nullopt).changes) {
    const bool may_stay = change.origin.empty() && !near.contains(change.key);
    if (!change.is_known_above || IsRemoval(change.kind) || may_stay) continue;
    if (known.contains(change.key)) continue;
    TakeRemoval(choices, change.key, change.stamp_us, taken);
  }
  if (!IsEmpty(taken.rows)) {
    StoreFollowed(storage, maps, *turn, taken.rows, {}, UnknownAboveIn(storage));
  }
  if (!taken.obstacles.removed.empty()) {
    storage.obstacles.Merge({{}, taken.obstacles.removed, true});
  }
}

}  // namespace freelsd
