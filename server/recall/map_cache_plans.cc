// Plans and planners of the cache's sites.
#include <algorithm>

#include <nlohmann/json.hpp>

#include "server/http/http.h"
#include "server/recall/map_cache.h"
#include "server/recall/other_maps/other_maps.h"

namespace freelsd {
namespace {

constexpr size_t kMaxNumPlansKept = 8;
// Of one entry, with the ids of its obstacles.
constexpr size_t kBytesOfObstruction = 256;
// Plans that stay without their map: of one site, and the size of one.
constexpr size_t kMaxNumPlansOfSite = 64;
constexpr size_t kBytesPerPlan = size_t{16} << 10;

// The exact bytes: any other wind needs another plan.
std::string WindKey(const std::optional<Eigen::Vector2d>& wind) {
  if (!wind) return {};
  return {reinterpret_cast<const char*>(wind->data()), 2 * sizeof(double)};
}

}  // namespace

MapCache::Planned* MapCache::FindSame(const std::shared_ptr<const KeptSite>& site) {
  Planned* const planned = sites_.Find(site->row.id);
  return planned != nullptr && planned->site == site ? planned : nullptr;
}

MapCache::Planner* MapCache::FindPlanner(const std::shared_ptr<const KeptSite>& site,
                                         const std::string& aircraft_key) {
  Planned* const planned = FindSame(site);
  if (planned == nullptr) return nullptr;
  std::list<Planner>& planners = planned->planners;
  const auto found = std::find_if(planners.begin(), planners.end(), [&](const Planner& each) {
    return each.aircraft_key == aircraft_key;
  });
  if (found == planners.end()) return nullptr;
  planners.splice(planners.begin(), planners, found);
  return &planners.front();
}

std::optional<std::optional<Obstruction>> MapCache::KeptObstruction(
    const SiteRow& site, const std::string& obstacles_key) {
  const std::lock_guard lock(mutex_);
  const KnownObstruction* const known = obstructions_.Find(site.id, site.updated_at_us);
  if (known == nullptr || known->obstacles_key != obstacles_key) return std::nullopt;
  return known->obstruction;
}

void MapCache::KeepObstruction(const SiteRow& site,
                               const std::string& obstacles_key,
                               const std::optional<Obstruction>& obstruction) {
  const std::lock_guard lock(mutex_);
  obstructions_.Keep(
      site.id, site.updated_at_us, kBytesOfObstruction, {obstacles_key, obstruction});
}

void MapCache::DropPlans(const std::string& site_id) {
  const std::lock_guard lock(mutex_);
  sites_.Erase(site_id);
  plans_.Erase(site_id);
}

std::optional<KeptPlan> MapCache::FindPlan(const Storage& storage,
                                           const RecallRow& row,
                                           const std::string& key) {
  std::optional<KeptPlan> kept;
  {
    const std::lock_guard lock(mutex_);
    PlansOfSite* const plans = plans_.Find(row.site_id, row.updated_at_us);
    if (plans == nullptr) return std::nullopt;
    const auto found = std::find_if(
        plans->begin(), plans->end(), [&key](const auto& each) { return each.first == key; });
    if (found == plans->end()) return std::nullopt;
    plans->splice(plans->begin(), *plans, found);
    kept = found->second;
  }
  const std::string now = SurroundingsOf(storage, row.flight_id, kept->surroundings).Key();
  return now == kept->surroundings_key ? kept : std::nullopt;
}

std::optional<KeptPlan> MapCache::PlanOf(const Storage& storage,
                                         const RecallRow& row,
                                         const Aircraft& aircraft,
                                         const std::string& aircraft_key,
                                         const std::optional<Eigen::Vector2d>& wind_in_world) {
  const std::string key = WindKey(wind_in_world) + aircraft_key;
  if (auto kept = FindPlan(storage, row, key)) return kept;
  const SemaphoreSlot turn(planning_);
  // Whoever had a turn meanwhile may have made it.
  if (auto kept = FindPlan(storage, row, key)) return kept;
  auto site = Get(storage, row.site_id, row.updated_at_us);
  if (!site) return std::nullopt;
  site = Covering(storage, site, aircraft, wind_in_world);
  const KeptPlan made{site->replan.origin,
                      PlanFor(storage, site, aircraft, wind_in_world),
                      site->surroundings,
                      site->surroundings_key};
  const std::lock_guard lock(mutex_);
  PlansOfSite plans;
  if (PlansOfSite* const kept = plans_.Find(row.site_id, row.updated_at_us)) plans.swap(*kept);
  // A plan in other surroundings.
  plans.remove_if([&key](const auto& each) { return each.first == key; });
  plans.emplace_front(key, made);
  if (plans.size() > kMaxNumPlansOfSite) plans.pop_back();
  const size_t num_bytes = kBytesPerPlan * plans.size();
  plans_.Keep(row.site_id, row.updated_at_us, num_bytes, std::move(plans));
  return made;
}

std::shared_ptr<const StoredMapPlanner> MapCache::PlannerFor(
    const std::shared_ptr<const KeptSite>& site, const Aircraft& aircraft) {
  const std::string aircraft_key = AircraftJson(aircraft).dump();
  {
    const std::lock_guard lock(mutex_);
    if (const Planner* const planner = FindPlanner(site, aircraft_key)) return planner->on_map;
  }
  auto on_map =
      std::make_shared<const StoredMapPlanner>(site->replan, aircraft, site->obstructed_map);
  const std::lock_guard lock(mutex_);
  Planned* const planned = FindSame(site);
  if (planned == nullptr || FindPlanner(site, aircraft_key) != nullptr) return on_map;
  planned->planners.push_front({aircraft_key, on_map, {}});
  if (planned->planners.size() > kMaxNumPlannersKept) planned->planners.pop_back();
  return on_map;
}

std::shared_ptr<const Plan> MapCache::PlanFor(const Storage& storage,
                                              const std::shared_ptr<const KeptSite>& site,
                                              const Aircraft& aircraft,
                                              const std::optional<Eigen::Vector2d>& wind_in_world) {
  const std::string aircraft_key = AircraftJson(aircraft).dump();
  const std::string wind_key = WindKey(wind_in_world);
  {
    const std::lock_guard lock(mutex_);
    if (const Planner* const planner = FindPlanner(site, aircraft_key)) {
      for (const auto& [kept_key, plan] : planner->plans) {
        if (kept_key == wind_key) return plan;
      }
    }
  }
  const auto on_map = PlannerFor(site, aircraft);
  auto plan = std::make_shared<const Plan>(CheckedAround(
      on_map->planner.PlanFor(wind_in_world), {storage, *this}, *site, aircraft, wind_in_world));
  const std::lock_guard lock(mutex_);
  Planner* const planner = FindPlanner(site, aircraft_key);
  if (planner == nullptr) return plan;
  planner->plans.emplace_front(wind_key, plan);
  if (planner->plans.size() > kMaxNumPlansKept) planner->plans.pop_back();
  return plan;
}

}  // namespace freelsd
