// Caches stored sites with their maps, the terrain of maps, and plans on maps. Recall plans
// approaches on these maps and checks the terrain below the path to a site.
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

// A cached site with its map.
struct KeptSite {
  SiteRow row;
  Replan replan;
  SiteMap site_map;
};

// The part of a site's map that is needed to check a flight over it.
struct KeptTerrain {
  GeoPoint origin;
  Grid grid;
  // Height of the highest object in each cell, or of the ground (ElevationMap::upper).
  cv::Mat1f upper;
};

// Thread-safe. Returned objects stay valid and never change. The constructor's arguments limit the
// memory.
class MapCache {
 public:
  MapCache(size_t max_bytes_of_sites, size_t max_bytes_of_terrain)
      : sites_(max_bytes_of_sites), terrains_(max_bytes_of_terrain) {}

  // The site as of the update at updated_at_us, or as stored now if that version is gone. Nothing
  // if the site has no map or its map cannot be read.
  std::shared_ptr<const KeptSite> Get(const Storage& storage,
                                      const std::string& site_id,
                                      int64_t updated_at_us);
  // The terrain of the site's map. It needs a fraction of the memory of a whole site.
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
  // Drops the site, its map and its plans, but not its terrain. Call it for a site that is no
  // longer a landing site.
  void DropPlans(const std::string& site_id);

 private:
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

  // Guards sites_ and terrains_.
  std::mutex mutex_;
  SiteLru<Planned> sites_;
  SiteLru<std::shared_ptr<const KeptTerrain>> terrains_;
};

}  // namespace freelsd
