// A cache of stored sites with their maps, of the terrain of maps, and of plans on maps. Recall
// plans approaches on these maps and checks its ways over them.
#pragma once

#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "api/export/layers/layers.h"
#include "api/stored/stored.h"
#include "server/recall/replan.h"
#include "server/recall/site_lru.h"
#include "storage/storage.h"

namespace freelsd {

// A site with its map.
struct KeptSite {
  SiteRow row;
  Replan replan;
  SiteMap site_map;
};

// The part of a site's map that a way over it needs.
struct KeptTerrain {
  GeoPoint origin;
  Grid grid;
  // Height of the highest object or ground in each cell.
  cv::Mat1f upper;
};

// Thread-safe. Returned objects stay valid and never change. The sizes are upper bounds in bytes.
class MapCache {
 public:
  MapCache(size_t max_bytes_of_sites, size_t max_bytes_of_terrain)
      : sites_(max_bytes_of_sites), terrains_(max_bytes_of_terrain) {}

  // The site as of this update. Nothing if the site has no map, or a map that cannot be read.
  std::shared_ptr<const KeptSite> Get(const Storage& storage,
                                      const std::string& site_id,
                                      int64_t updated_at_us);
  // The terrain of the site's map. It takes a fraction of the memory of Get.
  std::shared_ptr<const KeptTerrain> TerrainOf(const Storage& storage,
                                               const std::string& site_id,
                                               int64_t updated_at_us);
  // A planner for this aircraft on the site's map. `site` must outlive it. Cached.
  std::shared_ptr<const StoredMapPlanner> PlannerFor(const std::shared_ptr<const KeptSite>& site,
                                                     const Aircraft& aircraft);
  // The plan for this aircraft and wind on the site's map. Cached.
  std::shared_ptr<const Plan> PlanFor(const std::shared_ptr<const KeptSite>& site,
                                      const Aircraft& aircraft,
                                      const std::optional<Eigen::Vector2d>& wind_in_world);
  // Drops the site, its map and its plans, but not its terrain; for a site that is not a landing
  // site any more.
  void DropPlans(const std::string& site_id);

 private:
  struct Planner {
    std::string aircraft_key;
    std::shared_ptr<const StoredMapPlanner> on_map;
    // By wind; the latest is first.
    std::list<std::pair<std::string, std::shared_ptr<const Plan>>> plans;
  };
  struct Planned {
    std::shared_ptr<const KeptSite> site;
    // The latest is first.
    std::list<Planner> planners;
  };
  // The caller holds mutex_. Both find an entry only if the cache holds this very object, because
  // planners refer to its map.
  Planned* FindSame(const std::shared_ptr<const KeptSite>& site);
  Planner* FindPlanner(const std::shared_ptr<const KeptSite>& site,
                       const std::string& aircraft_key);

  // Guards sites_ and terrains_.
  std::mutex mutex_;
  SiteLru<Planned> sites_;
  SiteLru<std::shared_ptr<const KeptTerrain>> terrains_;
};

}  // namespace freelsd
