// Stored sites with their maps, read once and kept while they are used: recall plans on them and
// flies over them.
#pragma once

#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "api/export/export.h"
#include "server/replan.h"
#include "server/site_lru.h"
#include "storage/storage.h"

namespace freelsd {

struct KeptSite {
  SiteRow row;
  Replan replan;
  SiteMap site_map;
};

// What flying over a site's map needs: what stands highest in each cell.
struct KeptTerrain {
  GeoPoint origin;
  Grid grid;
  cv::Mat1f upper;
};

// Thread-safe; what is given out stays whole.
class MapCache {
 public:
  MapCache(size_t max_bytes_of_sites, size_t max_bytes_of_terrain)
      : sites_(max_bytes_of_sites), terrains_(max_bytes_of_terrain) {}

  // As of this update. Nothing where the site has no map, or one that cannot be read.
  std::shared_ptr<const KeptSite> Get(const Storage& storage,
                                      const std::string& site_id,
                                      int64_t updated_at_us);
  // Of many maps over the same ground: takes a fraction of the memory of Get.
  std::shared_ptr<const KeptTerrain> TerrainOf(const Storage& storage,
                                               const std::string& site_id,
                                               int64_t updated_at_us);
  // For this aircraft on the site's map, which must live as long; made once while both stay.
  std::shared_ptr<const StoredMapPlanner> PlannerFor(const std::shared_ptr<const KeptSite>& site,
                                                     const Aircraft& aircraft);
  // The plan on its map for this aircraft and wind; made once while both stay the same.
  std::shared_ptr<const Plan> PlanFor(const std::shared_ptr<const KeptSite>& site,
                                      const Aircraft& aircraft,
                                      const std::optional<Eigen::Vector2d>& wind_in_world);
  // Of a site that nobody will land on: its map. Its terrain still counts.
  void DropPlans(const std::string& site_id);

 private:
  struct Planner {
    std::string aircraft_key;
    std::shared_ptr<const StoredMapPlanner> on_map;
    // Latest first, by wind.
    std::list<std::pair<std::string, std::shared_ptr<const Plan>>> plans;
  };
  struct Planned {
    std::shared_ptr<const KeptSite> site;
    // Latest first.
    std::list<Planner> planners;
  };
  // Both with the lock held. Only where this very map is kept: what is planned on it refers to it.
  Planned* FindSame(const std::shared_ptr<const KeptSite>& site);
  Planner* FindPlanner(const std::shared_ptr<const KeptSite>& site,
                       const std::string& aircraft_key);

  std::mutex mutex_;
  SiteLru<Planned> sites_;
  SiteLru<std::shared_ptr<const KeptTerrain>> terrains_;
};

}  // namespace freelsd
