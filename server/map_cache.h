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
#include "storage/storage.h"

namespace freelsd {

struct KeptSite {
  SiteRow row;
  Replan replan;
  SiteMap site_map;
};

// Thread-safe; what is given out stays whole.
class MapCache {
 public:
  explicit MapCache(size_t max_bytes) : max_bytes_(max_bytes) {}

  // Nothing where the site has no map, or one that cannot be read.
  std::shared_ptr<const KeptSite> Get(const Storage& storage,
                                      const std::string& site_id,
                                      int64_t updated_at_us);
  // For this aircraft on the site's map, which must live as long; made once while both stay.
  std::shared_ptr<const StoredMapPlanner> PlannerFor(const std::shared_ptr<const KeptSite>& site,
                                                     const Aircraft& aircraft);
  // The plan on its map for this aircraft and wind; made once while both stay the same.
  std::shared_ptr<const Plan> PlanFor(const std::shared_ptr<const KeptSite>& site,
                                      const Aircraft& aircraft,
                                      const std::optional<Eigen::Vector2d>& wind_in_world);

 private:
  struct Planner {
    std::string aircraft_key;
    std::shared_ptr<const StoredMapPlanner> on_map;
    // Latest first, by wind.
    std::list<std::pair<std::string, std::shared_ptr<const Plan>>> plans;
  };
  struct Entry {
    std::string key;
    size_t num_bytes = 0;
    std::shared_ptr<const KeptSite> site;
    // Latest first.
    std::list<Planner> planners;
  };
  using Entries = std::list<Entry>;
  // With the lock held; what is found moves to the front.
  Entry* Find(const std::string& key);
  Planner* FindPlanner(const std::string& key, const std::string& aircraft_key);
  void Keep(Entry entry);

  size_t max_bytes_;
  std::mutex mutex_;
  // Most recently used first.
  Entries entries_;
  size_t num_bytes_ = 0;
};

}  // namespace freelsd
