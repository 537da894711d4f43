// Caches stored sites with the maps around them, the terrain of maps, and plans on maps. Recall
// plans approaches on these maps and checks the terrain below the path to a site.
#pragma once

#include <algorithm>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <semaphore>
#include <string>
#include <thread>
#include <utility>

#include "api/export/layers/layers.h"
#include "api/stored/stored.h"
#include "server/maps/maps.h"
#include "server/recall/kept_terrain.h"
#include "server/recall/obstacles/obstacles.h"
#include "server/recall/replan.h"
#include "server/recall/site_lru.h"
#include "storage/storage.h"

namespace freelsd {

struct OtherGround;

// A cached site with its map, and with what was near when it was asked for.
struct KeptSite {
  SiteRow row;
  Replan replan;
  // As photographed: the cells of the flight's map within `reach` of the site.
  SiteMap site_map;
  // See PlanReach.
  double reach = 0.0;
  // The map, and the map with all that its circles may reach.
  BoundingBox box{}, surroundings{};
  // Of the obstacles in `surroundings`, and of the maps of other flights there.
  std::string surroundings_key = {};
  std::vector<HardObstacle> obstacles = {};
  SharedRows<MapRow> other_maps = {};
  // Plans are made on it: site_map with the obstacles, and with the ground of other maps where it
  // is unseen.
  SiteMap obstructed_map = {};
};

// A plan on a site's map.
struct KeptPlan {
  // Of the plan's world frame.
  GeoPoint origin;
  std::shared_ptr<const Plan> plan;
  // As of KeptSite.
  BoundingBox surroundings{};
  std::string surroundings_key = {};
};

struct CacheSizes {
  size_t max_bytes_of_sites;
  size_t max_bytes_of_terrain;
  size_t max_bytes_of_plans = size_t{64} << 20;
};

// Thread-safe. Returned objects stay valid and never change.
class MapCache {
 public:
  explicit MapCache(const CacheSizes& sizes)
      : flight_maps_(kMaxBytesOfTiles),
        sites_(sizes.max_bytes_of_sites),
        plans_(sizes.max_bytes_of_plans),
        terrains_(sizes.max_bytes_of_terrain),
        obstructions_(kMaxBytesOfObstructions) {}

  FlightMaps& flight_maps() { return flight_maps_; }
  // The obstacles that are in force now and may meet the box.
  KnownObstacles ObstaclesNear(const Storage& storage, const BoundingBox& box);
  // When the next obstacle expires; nothing if none does.
  std::optional<int64_t> NextObstacleExpiryUs(const Storage& storage);
  // The site as of the update at updated_at_us, or as stored now if that version is gone; with what
  // is near it now. The map reaches far enough for the site's own aircraft and wind, and at
  // least `reach`. Nothing if the site has no map or its map cannot be read.
  std::shared_ptr<const KeptSite> Get(const Storage& storage,
                                      const std::string& site_id,
                                      int64_t updated_at_us,
                                      double reach = 0.0);
  // The same site on a map that reaches far enough for this aircraft and wind.
  std::shared_ptr<const KeptSite> Covering(const Storage& storage,
                                           const std::shared_ptr<const KeptSite>& site,
                                           const Aircraft& aircraft,
                                           const std::optional<Eigen::Vector2d>& wind_in_world);
  // A site that is not stored, with what is near it now.
  KeptSite InSurroundings(const Storage& storage, KeptSite site);
  // The terrain of a map. It needs a fraction of the map's memory.
  std::shared_ptr<const KeptTerrain> TerrainOf(const Storage& storage, const std::string& map_id);
  // A planner for this aircraft on the site's map. `site` must outlive it. Cached.
  std::shared_ptr<const StoredMapPlanner> PlannerFor(const std::shared_ptr<const KeptSite>& site,
                                                     const Aircraft& aircraft);
  // The plan for this aircraft and wind on the site's map, checked on later maps. Cached.
  std::shared_ptr<const Plan> PlanFor(const Storage& storage,
                                      const std::shared_ptr<const KeptSite>& site,
                                      const Aircraft& aircraft,
                                      const std::optional<Eigen::Vector2d>& wind_in_world);
  // What KeepObstruction kept for this update of the site and for these obstacles; nothing if
  // nothing was kept.
  std::optional<std::optional<Obstruction>> KeptObstruction(const SiteRow& site,
                                                            const std::string& obstacles_key);
  void KeepObstruction(const SiteRow& site,
                       const std::string& obstacles_key,
                       const std::optional<Obstruction>& obstruction);
  // The same for the site as of the update at updated_at_us. `aircraft_key` differs from aircraft
  // to aircraft. The plan stays when the cache drops the map, which needs far more memory. Nothing
  // as in Get.
  std::optional<KeptPlan> PlanOf(const Storage& storage,
                                 const RecallRow& row,
                                 const Aircraft& aircraft,
                                 const std::string& aircraft_key,
                                 const std::optional<Eigen::Vector2d>& wind_in_world);
  // Drops the site, its map and its plans, but not its terrain. Call it for a site that is no
  // longer a landing site.
  void DropPlans(const std::string& site_id);

  static constexpr size_t kMaxNumPlannersKept = 2;

 private:
  static constexpr size_t kMaxBytesOfTiles = size_t{64} << 20;
  struct Planner {
    std::string aircraft_key;
    std::shared_ptr<const StoredMapPlanner> on_map;
    // Plans by wind, the latest first.
    std::list<std::pair<std::string, std::shared_ptr<const Plan>>> plans;
  };
  struct Planned {
    std::shared_ptr<const KeptSite> site;
    // The latest planner is first.
    std::list<Planner> planners;
  };
  // The caller holds mutex_. FindSame and FindPlanner return nullptr unless the cache holds this
  // same object, because planners refer to its map.
  Planned* FindSame(const std::shared_ptr<const KeptSite>& site);
  Planner* FindPlanner(const std::shared_ptr<const KeptSite>& site,
                       const std::string& aircraft_key);

  struct KnownObstruction {
    std::string obstacles_key;
    std::optional<Obstruction> obstruction;
  };
  static constexpr size_t kMaxBytesOfObstructions = size_t{1} << 20;

  // What counts in a plan besides its own map.
  struct Surroundings {
    KnownObstacles obstacles;
    SharedRows<MapRow> other_maps;

    std::string Key() const;
  };
  Surroundings SurroundingsOf(const Storage& storage,
                              const std::string& flight_id,
                              const BoundingBox& surroundings);
  std::vector<OtherGround> GroundsOf(const Storage& storage, const SharedRows<MapRow>& maps);
  std::shared_ptr<const KeptSite> Among(const Storage& storage,
                                        const KeptSite& site,
                                        const Surroundings& surroundings);
  std::shared_ptr<const KeptSite> ReadSiteSafely(const Storage& storage,
                                                 const std::string& site_id,
                                                 double reach);
  KeptSite ReadSite(const Storage& storage, const SiteRow& row, double reach);
  std::shared_ptr<const KeptTerrain> ReadTerrain(const Storage& storage, const std::string& map_id);

  // The plan of this key (aircraft and wind) if it holds in what is near now.
  std::optional<KeptPlan> FindPlan(const Storage& storage,
                                   const RecallRow& row,
                                   const std::string& key);

  // Making a plan takes one processor and a map in memory: more at once only take each other's.
  std::counting_semaphore<> planning_{
      1 + static_cast<std::ptrdiff_t>(std::max(1U, std::thread::hardware_concurrency()))};
  ObstacleCache obstacles_;
  FlightMaps flight_maps_;
  // By aircraft and wind, the latest first.
  using PlansOfSite = std::list<std::pair<std::string, KeptPlan>>;

  // Guards sites_, plans_, terrains_ and obstructions_.
  std::mutex mutex_;
  SiteLru<Planned> sites_;
  SiteLru<PlansOfSite> plans_;
  SiteLru<std::shared_ptr<const KeptTerrain>> terrains_;
  SiteLru<KnownObstruction> obstructions_;
};

}  // namespace freelsd
