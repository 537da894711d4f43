#include "server/map_cache.h"

#include <algorithm>
#include <cstring>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

namespace freelsd {
namespace {

// Eight layers of float and one of bytes. Of each aircraft one more of both, and the surface that
// its planner clears: two of float and three of bytes.
constexpr size_t kMaxNumPlannersKept = 2;
constexpr size_t kBytesPerCell = 33 + (5 + 11) * kMaxNumPlannersKept;
constexpr size_t kMaxNumPlansKept = 8;

std::string KeyOf(const std::string& site_id, int64_t updated_at_us) {
  return site_id + "@" + std::to_string(updated_at_us);
}

// Exact: another wind is another plan.
std::string WindKey(const std::optional<Eigen::Vector2d>& wind) {
  if (!wind) return {};
  return {reinterpret_cast<const char*>(wind->data()), 2 * sizeof(double)};
}

// Nothing where it cannot be used: one damaged site must not keep the others from an emergency.
std::shared_ptr<const KeptSite> ReadSite(const Storage& storage, const std::string& site_id) {
  const std::optional<SiteRow> row = storage.FindSite(site_id);
  const std::optional<std::string> blob = storage.ReadSiteMap(site_id);
  if (!row || !blob) return nullptr;
  return std::make_shared<const KeptSite>(
      KeptSite{*row, ParseReplan(row->replan_json), DeserializeSiteMap(*blob)});
}

std::shared_ptr<const KeptSite> ReadSiteSafely(const Storage& storage, const std::string& site_id) {
  try {
    return ReadSite(storage, site_id);
  } catch (const StorageError&) {
    throw;
  } catch (const DamagedMap& error) {
    // There is a second copy of it.
    spdlog::error("site {}: {}", site_id, error.what());
    storage.MarkDamaged(std::string("site ").append(site_id).append(": ").append(error.what()));
  } catch (const std::exception& error) {
    // Written by another version, or too large for today's memory: no reason to give up the rest.
    spdlog::error("site {} cannot be used: {}", site_id, error.what());
    return nullptr;
  }
  try {
    return ReadSite(storage, site_id);
  } catch (const std::exception& error) {
    spdlog::error("site {}, second copy: {}", site_id, error.what());
    return nullptr;
  }
}

}  // namespace

MapCache::Entry* MapCache::Find(const std::string& key) {
  const auto found = std::find_if(
      entries_.begin(), entries_.end(), [&key](const Entry& each) { return each.key == key; });
  if (found == entries_.end()) return nullptr;
  entries_.splice(entries_.begin(), entries_, found);
  return &entries_.front();
}

MapCache::Planner* MapCache::FindPlanner(const std::string& key, const std::string& aircraft_key) {
  Entry* const entry = Find(key);
  if (entry == nullptr) return nullptr;
  std::list<Planner>& planners = entry->planners;
  const auto found = std::find_if(planners.begin(), planners.end(), [&](const Planner& each) {
    return each.aircraft_key == aircraft_key;
  });
  if (found == planners.end()) return nullptr;
  planners.splice(planners.begin(), planners, found);
  return &planners.front();
}

void MapCache::Keep(Entry entry) {
  const std::lock_guard lock(mutex_);
  if (Find(entry.key) != nullptr) return;
  num_bytes_ += entry.num_bytes;
  entries_.push_front(std::move(entry));
  while (num_bytes_ > max_bytes_ && entries_.size() > 1) {
    num_bytes_ -= entries_.back().num_bytes;
    entries_.pop_back();
  }
}

std::shared_ptr<const KeptSite> MapCache::Get(const Storage& storage,
                                              const std::string& site_id,
                                              int64_t updated_at_us) {
  const std::string key = KeyOf(site_id, updated_at_us);
  {
    const std::lock_guard lock(mutex_);
    if (const Entry* entry = Find(key)) return entry->site;
  }
  const std::shared_ptr<const KeptSite> site = ReadSiteSafely(storage, site_id);
  if (!site) return nullptr;
  const Grid& grid = site->site_map.map.grid;
  const size_t num_cells = static_cast<size_t>(grid.num_rows) * static_cast<size_t>(grid.num_cols);
  Keep({key, num_cells * kBytesPerCell, site, {}});
  return site;
}

std::shared_ptr<const StoredMapPlanner> MapCache::PlannerFor(
    const std::shared_ptr<const KeptSite>& site, const Aircraft& aircraft) {
  const std::string key = KeyOf(site->row.id, site->row.updated_at_us);
  const std::string aircraft_key = AircraftJson(aircraft).dump();
  // Another thread may have read the site anew since: what is kept refers to the map beside it.
  const auto kept = [&]() -> Entry* {
    Entry* const entry = Find(key);
    return entry != nullptr && entry->site == site ? entry : nullptr;
  };
  {
    const std::lock_guard lock(mutex_);
    if (kept() != nullptr) {
      if (const Planner* const planner = FindPlanner(key, aircraft_key)) return planner->on_map;
    }
  }
  auto on_map = std::make_shared<const StoredMapPlanner>(site->replan, aircraft, site->site_map);
  const std::lock_guard lock(mutex_);
  Entry* const entry = kept();
  if (entry == nullptr || FindPlanner(key, aircraft_key) != nullptr) return on_map;
  entry->planners.push_front({aircraft_key, on_map, {}});
  if (entry->planners.size() > kMaxNumPlannersKept) entry->planners.pop_back();
  return on_map;
}

std::shared_ptr<const Plan> MapCache::PlanFor(const std::shared_ptr<const KeptSite>& site,
                                              const Aircraft& aircraft,
                                              const std::optional<Eigen::Vector2d>& wind_in_world) {
  const std::string key = KeyOf(site->row.id, site->row.updated_at_us);
  const std::string aircraft_key = AircraftJson(aircraft).dump();
  const std::string wind_key = WindKey(wind_in_world);
  {
    const std::lock_guard lock(mutex_);
    if (const Planner* const planner = FindPlanner(key, aircraft_key)) {
      for (const auto& [kept_key, plan] : planner->plans) {
        if (kept_key == wind_key) return plan;
      }
    }
  }
  const auto on_map = PlannerFor(site, aircraft);
  const auto plan = std::make_shared<const Plan>(on_map->planner.PlanFor(wind_in_world));
  const std::lock_guard lock(mutex_);
  Planner* const planner = FindPlanner(key, aircraft_key);
  if (planner == nullptr) return plan;
  planner->plans.emplace_front(wind_key, plan);
  if (planner->plans.size() > kMaxNumPlansKept) planner->plans.pop_back();
  return plan;
}

}  // namespace freelsd
