#include "server/recall/map_cache.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "server/http/http.h"

namespace freelsd {
namespace {

// A map has eight layers of float and one of bytes. Each planner adds one layer of float and one of
// bytes, and the surface that it clears: two layers of float and three of bytes.
constexpr size_t kMaxNumPlannersKept = 2;
constexpr size_t kBytesPerCell = 33 + (5 + 11) * kMaxNumPlannersKept;
constexpr size_t kMaxNumPlansKept = 8;
// With obstacles, two more layers of float.
constexpr size_t kBytesPerObstructedCell = 8;
// From the edge of a map to the far side of a circle that begins on it.
constexpr double kSurroundingsM = 1000.0;
// Of one entry, with the ids of its obstacles.
constexpr size_t kBytesOfObstruction = 256;
// Plans that stay without their map: of one site, and the size of one.
constexpr size_t kMaxNumPlansOfSite = 64;
constexpr size_t kBytesPerPlan = size_t{16} << 10;
// Blocks of terrain are at most so wide: a margin over terrain counts in metres.
constexpr double kMaxBlockM = 2.0;

size_t NumCells(const Grid& grid) {
  return static_cast<size_t>(grid.num_rows) * static_cast<size_t>(grid.num_cols);
}

// The exact bytes: any other wind needs another plan.
std::string WindKey(const std::optional<Eigen::Vector2d>& wind) {
  if (!wind) return {};
  return {reinterpret_cast<const char*>(wind->data()), 2 * sizeof(double)};
}

// The box of the map, widened.
BoundingBox SurroundingsOf(const GeoPoint& origin, const Grid& grid) {
  const Eigen::Vector2d half_size =
      0.5 * grid.cell_size_m * Eigen::Vector2d(grid.num_cols, -grid.num_rows);
  const Eigen::Vector2d middle = grid.north_west_in_world + half_size;
  const GeoPoint place = LocalFrame(origin).GeoFromWorld({middle.x(), middle.y(), 0.0});
  return BoxAroundPlace(place, half_size.norm() + kSurroundingsM);
}

AltitudeReference ReferenceOf(const KeptSite& site) {
  const std::optional<std::string>& datum = site.replan.flight.altitude_datum;
  return {datum ? std::string_view(*datum) : "unknown",
          site.replan.origin.latitude_deg,
          site.replan.origin.longitude_deg,
          site.row.flight_id};
}

std::shared_ptr<const KeptSite> Obstructed(const KeptSite& site, const KnownObstacles& obstacles) {
  auto kept = std::make_shared<KeptSite>(site);
  kept->obstacles_key = KeyOf(obstacles);
  kept->obstacles = InWorld(obstacles, LocalFrame(site.replan.origin), ReferenceOf(site));
  AssessedMap ground = WithObstacles(site.site_map.map, site.site_map.layers, kept->obstacles, {});
  kept->obstructed_map = {std::move(ground.map), std::move(ground.layers)};
  return kept;
}

// Never lower than the map.
KeptTerrain TerrainOn(const KeptSite& site) {
  const ElevationMap& map = site.obstructed_map.map;
  const int side = std::max(1, static_cast<int>(std::floor(kMaxBlockM / map.grid.cell_size_m)));
  KeptTerrain terrain{site.replan.origin, map.grid, {}, {}, site.surroundings, site.obstacles_key};
  terrain.grid.cell_size_m *= side;
  terrain.grid.num_rows = (map.grid.num_rows + side - 1) / side;
  terrain.grid.num_cols = (map.grid.num_cols + side - 1) / side;
  const cv::Size size(terrain.grid.num_cols, terrain.grid.num_rows);
  terrain.upper = cv::Mat1f(size, std::numeric_limits<float>::quiet_NaN());
  cv::Mat1i num_seen(size, 0);
  for (int row = 0; row < map.grid.num_rows; ++row) {
    for (int col = 0; col < map.grid.num_cols; ++col) {
      const float height = map.upper(row, col);
      if (std::isnan(height)) continue;
      ++num_seen(row / side, col / side);
      float& highest = terrain.upper(row / side, col / side);
      if (!(highest >= height)) highest = height;
    }
  }
  terrain.is_seen = (num_seen == side * side) / 255;
  return terrain;
}

// Level of the map whose cells are the largest that a block may be.
int LevelOfBlocks(const MapHead& head) {
  int level = 0;
  while (level + 1 < head.num_levels &&
         std::ldexp(head.grid.cell_size_m, level + 1) <= kMaxBlockM) {
    ++level;
  }
  return level;
}

double ReachFor(const Replan& replan,
                const Aircraft& aircraft,
                const std::optional<Eigen::Vector2d>& wind_in_world) {
  const PipelineOptions& options = replan.flight.options;
  return PlanReach(aircraft,
                   wind_in_world,
                   replan.request.wind_spread_mps,
                   options.backend.max_surroundings_m,
                   options.approach);
}

}  // namespace

KeptSite MapCache::ReadSite(const Storage& storage,
                            const SiteRow& row,
                            const std::optional<std::string>& own_map,
                            double reach) {
  KeptSite kept;
  kept.row = row;
  kept.replan = ParseReplan(row.replan_json);
  if (own_map) {
    kept.reach = std::numeric_limits<double>::infinity();
    kept.site_map = DeserializeSiteMap(*own_map);
  } else {
    const auto map = flight_maps_.Find(storage, row.map_id);
    if (!map) throw std::runtime_error("its map " + row.map_id + " is not stored");
    const auto& [flight, origin, request] = kept.replan;
    kept.reach = std::max(reach, ReachFor(kept.replan, flight.aircraft, request.wind_in_world));
    const Grid& whole = map->head.grid;
    const Grid around = whole.Part(whole.CellsAround(request.footprint, kept.reach));
    kept.site_map = flight_maps_.Read(storage, *map, 0, around, TileLayers::kPlanning).site_map;
  }
  kept.surroundings = SurroundingsOf(kept.replan.origin, kept.site_map.map.grid);
  return kept;
}

// Nothing if the site cannot be used: one damaged site must not fail the whole answer.
std::shared_ptr<const KeptSite> MapCache::ReadSiteSafely(const Storage& storage,
                                                         const std::string& site_id,
                                                         double reach) {
  const auto read = [&]() -> std::shared_ptr<const KeptSite> {
    const std::optional<SiteRow> row = storage.sites.Find(site_id);
    if (!row) return nullptr;
    const auto own_map = row->map_id.empty() ? storage.sites.ReadMap(site_id) : std::nullopt;
    if (row->map_id.empty() && !own_map) return nullptr;
    return std::make_shared<const KeptSite>(ReadSite(storage, *row, own_map, reach));
  };
  try {
    return read();
  } catch (const StorageError&) {
    throw;
  } catch (const DamagedMap& error) {
    // From now on storage reads from the second copy.
    spdlog::error("site {}: {}", site_id, error.what());
    storage.MarkDamaged(std::string("site ").append(site_id).append(": ").append(error.what()));
  } catch (const std::exception& error) {
    // Another version wrote it, or memory is short. Other sites can still be used.
    spdlog::error("site {} cannot be used: {}", site_id, error.what());
    return nullptr;
  }
  try {
    return read();
  } catch (const std::exception& error) {
    spdlog::error("site {}, second copy: {}", site_id, error.what());
    return nullptr;
  }
}

std::shared_ptr<const KeptTerrain> MapCache::ReadTerrain(const Storage& storage,
                                                         const std::string& map_id) {
  const auto map = flight_maps_.Find(storage, map_id);
  if (!map) return nullptr;
  const int level = LevelOfBlocks(map->head);
  const Grid grid = map->GridAt(level);
  const SiteMap blocks =
      flight_maps_.Read(storage, *map, level, grid, TileLayers::kPlanning).site_map;
  KeptTerrain terrain{map->head.origin, grid, {}, {}, SurroundingsOf(map->head.origin, grid), {}};
  const KnownObstacles obstacles = ObstaclesNear(storage, terrain.surroundings);
  terrain.obstacles_key = KeyOf(obstacles);
  const AltitudeReference reference{map->row.altitude_datum,
                                    map->head.origin.latitude_deg,
                                    map->head.origin.longitude_deg,
                                    map->row.flight_id};
  terrain.upper =
      WithObstacles(blocks.map, blocks.layers, InWorld(obstacles, map->local_frame, reference), {})
          .map.upper;
  // The number of points of a block is unknown if one of its cells is unseen.
  terrain.is_seen = (blocks.map.num_points == blocks.map.num_points) / 255;
  return std::make_shared<const KeptTerrain>(std::move(terrain));
}

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

// Storage may hold another update than the requested one: a newer one, or an older one from the
// second copy of a damaged database. No other is available, so it is cached as the requested one.
std::shared_ptr<const KeptSite> MapCache::Get(const Storage& storage,
                                              const std::string& site_id,
                                              int64_t updated_at_us,
                                              double reach) {
  std::shared_ptr<const KeptSite> found;
  {
    const std::lock_guard lock(mutex_);
    const Planned* planned = sites_.Find(site_id, updated_at_us);
    if (planned != nullptr && planned->site->reach >= reach) found = planned->site;
  }
  const std::shared_ptr<const KeptSite> site =
      found ? found : ReadSiteSafely(storage, site_id, reach);
  if (!site) return nullptr;
  const KnownObstacles obstacles = ObstaclesNear(storage, site->surroundings);
  if (found && KeyOf(obstacles) == found->obstacles_key) return found;
  std::shared_ptr<const KeptSite> current = Obstructed(*site, obstacles);
  const std::lock_guard lock(mutex_);
  // Another thread may have cached it in the meantime, with plans that refer to its object.
  if (const Planned* planned = sites_.Find(site_id, updated_at_us);
      planned != nullptr && planned->site->obstacles_key == current->obstacles_key &&
      planned->site->reach >= reach) {
    return planned->site;
  }
  const size_t bytes_per_cell =
      kBytesPerCell + (current->obstacles.empty() ? 0 : kBytesPerObstructedCell);
  const size_t num_bytes = bytes_per_cell * NumCells(current->site_map.map.grid);
  sites_.Keep(site_id, updated_at_us, num_bytes, {current, {}});
  return current;
}

KeptSite MapCache::AmongObstacles(const Storage& storage, KeptSite site) {
  site.surroundings = SurroundingsOf(site.replan.origin, site.site_map.map.grid);
  return *Obstructed(site, ObstaclesNear(storage, site.surroundings));
}

std::shared_ptr<const KeptSite> MapCache::Covering(
    const Storage& storage,
    const std::shared_ptr<const KeptSite>& site,
    const Aircraft& aircraft,
    const std::optional<Eigen::Vector2d>& wind_in_world) {
  const double reach = ReachFor(site->replan, aircraft, wind_in_world);
  if (site->reach >= reach) return site;
  const auto wider = Get(storage, site->row.id, site->row.updated_at_us, reach);
  return wider ? wider : site;
}

std::shared_ptr<const KeptTerrain> MapCache::TerrainOf(const Storage& storage,
                                                       const std::string& map_id,
                                                       int64_t updated_at_us) {
  std::shared_ptr<const KeptSite> site;
  std::shared_ptr<const KeptTerrain> terrain;
  {
    const std::lock_guard lock(mutex_);
    if (const auto* found = terrains_.Find(map_id, updated_at_us)) terrain = *found;
    if (const Planned* planned = sites_.Find(map_id, updated_at_us)) site = planned->site;
  }
  if (terrain && KeyOf(ObstaclesNear(storage, terrain->surroundings)) == terrain->obstacles_key) {
    return terrain;
  }
  // No id of a site has a slash.
  if (map_id.find('/') != std::string::npos) {
    terrain = ReadTerrain(storage, map_id);
  } else {
    if (!site) site = ReadSiteSafely(storage, map_id, 0.0);
    if (!site) return nullptr;
    const KnownObstacles obstacles = ObstaclesNear(storage, site->surroundings);
    terrain = std::make_shared<const KeptTerrain>(TerrainOn(*Obstructed(*site, obstacles)));
  }
  if (!terrain) return nullptr;
  const size_t num_bytes = (sizeof(float) + sizeof(uchar)) * NumCells(terrain->grid);
  const std::lock_guard lock(mutex_);
  terrains_.Keep(map_id, updated_at_us, num_bytes, terrain);
  return terrain;
}

KnownObstacles MapCache::ObstaclesNear(const Storage& storage, const BoundingBox& box) {
  return obstacles_.Near(storage, box, NowUs());
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

std::optional<KeptPlan> MapCache::PlanOf(const Storage& storage,
                                         const RecallRow& row,
                                         const Aircraft& aircraft,
                                         const std::string& aircraft_key,
                                         const std::optional<Eigen::Vector2d>& wind_in_world) {
  const std::string key = WindKey(wind_in_world) + aircraft_key;
  std::optional<KeptPlan> kept_plan;
  {
    const std::lock_guard lock(mutex_);
    if (PlansOfSite* const plans = plans_.Find(row.site_id, row.updated_at_us)) {
      const auto found = std::find_if(
          plans->begin(), plans->end(), [&key](const auto& each) { return each.first == key; });
      if (found != plans->end()) {
        plans->splice(plans->begin(), *plans, found);
        kept_plan = found->second;
      }
    }
  }
  if (kept_plan &&
      KeyOf(ObstaclesNear(storage, kept_plan->surroundings)) == kept_plan->obstacles_key) {
    return kept_plan;
  }
  auto site = Get(storage, row.site_id, row.updated_at_us);
  if (!site) return std::nullopt;
  site = Covering(storage, site, aircraft, wind_in_world);
  const KeptPlan made{site->replan.origin,
                      PlanFor(site, aircraft, wind_in_world),
                      site->surroundings,
                      site->obstacles_key};
  const std::lock_guard lock(mutex_);
  PlansOfSite plans;
  if (PlansOfSite* const kept = plans_.Find(row.site_id, row.updated_at_us)) plans.swap(*kept);
  // A plan among other obstacles.
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

std::shared_ptr<const Plan> MapCache::PlanFor(const std::shared_ptr<const KeptSite>& site,
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
  auto plan = std::make_shared<const Plan>(CheckedBeyondMap(on_map->planner.PlanFor(wind_in_world),
                                                            site->obstructed_map.map,
                                                            aircraft,
                                                            site->obstacles,
                                                            {}));
  const std::lock_guard lock(mutex_);
  Planner* const planner = FindPlanner(site, aircraft_key);
  if (planner == nullptr) return plan;
  planner->plans.emplace_front(wind_key, plan);
  if (planner->plans.size() > kMaxNumPlansKept) planner->plans.pop_back();
  return plan;
}

}  // namespace freelsd
