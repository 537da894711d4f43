#include "server/recall/map_cache.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "server/http/http.h"
#include "server/recall/other_maps/other_maps.h"
#include "server/recall/terrain_margin.h"

namespace freelsd {
namespace {

// A map has eight layers of float and one of bytes. Each planner adds one layer of float and one of
// bytes, and the surface that it clears: two layers of float and three of bytes.
constexpr size_t kBytesPerCell = 33 + (5 + 11) * MapCache::kMaxNumPlannersKept;
// With obstacles, two more layers of float.
constexpr size_t kBytesPerObstructedCell = 8;
// From the edge of a map to the far side of a circle that begins on it.
constexpr double kCirclesM = 1000.0;
// Blocks of terrain are at most so wide: a margin over terrain counts in metres.
constexpr double kMaxBlockM = 2.0;

size_t NumCells(const Grid& grid) {
  return static_cast<size_t>(grid.num_rows) * static_cast<size_t>(grid.num_cols);
}

// The box of the map, widened.
BoundingBox BoxAround(const GeoPoint& origin, const Grid& grid, double margin_m) {
  const Eigen::Vector2d half_size =
      0.5 * grid.cell_size_m * Eigen::Vector2d(grid.num_cols, -grid.num_rows);
  const Eigen::Vector2d middle = grid.north_west_in_world + half_size;
  const GeoPoint place = LocalFrame(origin).GeoFromWorld({middle.x(), middle.y(), 0.0});
  return BoxAroundPlace(place, half_size.norm() + margin_m);
}

AltitudeReference ReferenceOf(const KeptSite& site) {
  const std::optional<std::string>& datum = site.replan.flight.altitude_datum;
  return {datum ? std::string_view(*datum) : "unknown",
          site.replan.origin.latitude_deg,
          site.replan.origin.longitude_deg,
          site.row.flight_id};
}

// A matrix of floats equals itself but where it is NaN.
bool IsAllSeen(const ElevationMap& map) {
  return cv::countNonZero(map.upper == map.upper) == static_cast<int>(map.upper.total());
}

SiteMap WithObstaclesOn(const SiteMap& site_map, const std::vector<HardObstacle>& obstacles) {
  AssessedMap ground = WithObstacles(site_map.map, site_map.layers, obstacles, {});
  return {std::move(ground.map), std::move(ground.layers)};
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

KeptSite MapCache::ReadSite(const Storage& storage, const SiteRow& row, double reach) {
  KeptSite kept;
  kept.row = row;
  kept.replan = ParseReplan(row.replan_json);
  const auto map = flight_maps_.Find(storage, row.map_id);
  if (!map) throw std::runtime_error("its map " + row.map_id + " is not stored");
  const auto& [flight, origin, request] = kept.replan;
  kept.reach = std::max(reach, ReachFor(kept.replan, flight.aircraft, request.wind_in_world));
  const Grid& whole = map->head.grid;
  const Grid around = whole.Part(whole.CellsAround(request.footprint, kept.reach));
  kept.site_map = flight_maps_.Read(storage, *map, 0, around, TileLayers::kPlanning).site_map;
  const Grid& grid = kept.site_map.map.grid;
  kept.box = BoxAround(kept.replan.origin, grid, 0.0);
  kept.surroundings = BoxAround(kept.replan.origin, grid, kCirclesM);
  return kept;
}

// Nothing if the site cannot be used: one damaged site must not fail the whole answer.
std::shared_ptr<const KeptSite> MapCache::ReadSiteSafely(const Storage& storage,
                                                         const std::string& site_id,
                                                         double reach) {
  try {
    const std::optional<SiteRow> row = storage.sites.Find(site_id);
    if (!row || row->map_id.empty()) return nullptr;
    return std::make_shared<const KeptSite>(ReadSite(storage, *row, reach));
  } catch (const StorageError&) {
    throw;
  } catch (const std::exception& error) {
    spdlog::error("site {} cannot be used: {}", site_id, error.what());
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
  KeptTerrain terrain;
  terrain.origin = map->head.origin;
  terrain.grid = grid;
  terrain.position_sd_m = map->head.position_sd_m;
  terrain.surroundings = BoxAround(map->head.origin, grid, kCirclesM);
  const KnownObstacles obstacles = ObstaclesNear(storage, terrain.surroundings);
  terrain.obstacles_key = KeyOf(obstacles);
  if (!map->memory.is_kept) terrain.experiment_id = map->row.flight_id;
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
  const Surroundings surroundings =
      SurroundingsOf(storage, site->row.flight_id, site->surroundings);
  if (found && surroundings.Key() == found->surroundings_key) return found;
  std::shared_ptr<const KeptSite> current = Among(storage, *site, surroundings);
  const std::lock_guard lock(mutex_);
  // Another thread may have cached it in the meantime, with plans that refer to its object.
  if (const Planned* planned = sites_.Find(site_id, updated_at_us);
      planned != nullptr && planned->site->surroundings_key == current->surroundings_key &&
      planned->site->reach >= reach) {
    return planned->site;
  }
  const size_t bytes_per_cell =
      kBytesPerCell + (current->surroundings_key.empty() ? 0 : kBytesPerObstructedCell);
  const size_t num_bytes = bytes_per_cell * NumCells(current->site_map.map.grid);
  sites_.Keep(site_id, updated_at_us, num_bytes, {current, {}});
  return current;
}

KeptSite MapCache::InSurroundings(const Storage& storage, KeptSite site) {
  const Grid& grid = site.site_map.map.grid;
  site.box = BoxAround(site.replan.origin, grid, 0.0);
  site.surroundings = BoxAround(site.replan.origin, grid, kCirclesM);
  return *Among(storage, site, SurroundingsOf(storage, site.row.flight_id, site.surroundings));
}

std::string MapCache::Surroundings::Key() const {
  std::string key = KeyOf(obstacles);
  for (const auto& map : other_maps) key.append(map->id).append(";");
  return key;
}

MapCache::Surroundings MapCache::SurroundingsOf(const Storage& storage,
                                                const std::string& flight_id,
                                                const BoundingBox& surroundings) {
  return {ObstaclesNear(storage, surroundings), MapsOfOthers(storage, flight_id, surroundings)};
}

std::vector<OtherGround> MapCache::GroundsOf(const Storage& storage,
                                             const SharedRows<MapRow>& maps) {
  std::vector<OtherGround> grounds;
  for (const auto& map : maps) {
    auto terrain = TerrainOf(storage, map->id);
    if (!terrain || !terrain->CountsFor(std::nullopt)) continue;
    const AltitudeReference reference = freelsd::ReferenceOf(*map, *terrain);
    grounds.push_back({std::move(terrain), reference});
  }
  return grounds;
}

std::shared_ptr<const KeptSite> MapCache::Among(const Storage& storage,
                                                const KeptSite& site,
                                                const Surroundings& surroundings) {
  auto kept = std::make_shared<KeptSite>(site);
  const AltitudeReference reference = ReferenceOf(*kept);
  kept->surroundings_key = surroundings.Key();
  kept->obstacles = InWorld(surroundings.obstacles, LocalFrame(site.replan.origin), reference);
  kept->other_maps = surroundings.other_maps;
  SiteMap ground = site.site_map;
  // Other maps are read only where they count.
  if (!IsAllSeen(ground.map)) {
    ground.map.upper =
        WithGroundOfOthers(ground.map,
                           site.replan.origin,
                           reference,
                           GroundsOf(storage, MapsOfOthers(storage, site.row.flight_id, kept->box)),
                           site.replan.flight.options.approach.path_margin_sigma);
  }
  kept->obstructed_map = WithObstaclesOn(ground, kept->obstacles);
  return kept;
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
                                                       const std::string& map_id) {
  // A stored map never changes.
  constexpr int64_t kVersion = 0;
  std::shared_ptr<const KeptTerrain> terrain;
  {
    const std::lock_guard lock(mutex_);
    if (const auto* found = terrains_.Find(map_id, kVersion)) terrain = *found;
  }
  if (terrain && KeyOf(ObstaclesNear(storage, terrain->surroundings)) == terrain->obstacles_key) {
    return terrain;
  }
  terrain = ReadTerrain(storage, map_id);
  if (!terrain) return nullptr;
  const size_t num_bytes = (sizeof(float) + sizeof(uchar)) * NumCells(terrain->grid);
  const std::lock_guard lock(mutex_);
  terrains_.Keep(map_id, kVersion, num_bytes, terrain);
  return terrain;
}

KnownObstacles MapCache::ObstaclesNear(const Storage& storage, const BoundingBox& box) {
  return obstacles_.Near(storage, box, NowUs());
}

std::optional<int64_t> MapCache::NextObstacleExpiryUs(const Storage& storage) {
  return obstacles_.NextExpiryUs(storage, NowUs());
}

}  // namespace freelsd
