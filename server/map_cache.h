// Stored maps, read once and kept while they are used: recall plans on them and flies over them.
#pragma once

#include <list>
#include <memory>
#include <mutex>
#include <string>

#include "api/api.h"
#include "api/export/export.h"
#include "storage/storage.h"

namespace freelsd {

class MapCache {
 public:
  explicit MapCache(size_t max_bytes) : max_bytes_(max_bytes) {}

  // Nothing where the site has no map, or one that cannot be read. Thread-safe; what is given out
  // stays whole.
  std::shared_ptr<const SiteMap> Get(const Storage& storage,
                                     const std::string& site_id,
                                     int64_t updated_at_us);

 private:
  struct Entry {
    std::string key;
    size_t num_bytes = 0;
    std::shared_ptr<const SiteMap> map;
  };
  std::shared_ptr<const SiteMap> Find(const std::string& key);
  void Keep(Entry entry);

  size_t max_bytes_;
  std::mutex mutex_;
  // Most recently used first.
  std::list<Entry> entries_;
  size_t num_bytes_ = 0;
};

}  // namespace freelsd
