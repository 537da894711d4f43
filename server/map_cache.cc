#include "server/map_cache.h"

#include <algorithm>
#include <utility>

#include <spdlog/spdlog.h>

namespace freelsd {
namespace {

// Eight layers of float and one of bytes.
constexpr size_t kBytesPerCell = 33;

}  // namespace

std::shared_ptr<const SiteMap> MapCache::Find(const std::string& key) {
  const std::lock_guard lock(mutex_);
  const auto found = std::find_if(
      entries_.begin(), entries_.end(), [&key](const Entry& each) { return each.key == key; });
  if (found == entries_.end()) return nullptr;
  entries_.splice(entries_.begin(), entries_, found);
  return found->map;
}

void MapCache::Keep(Entry entry) {
  const std::lock_guard lock(mutex_);
  num_bytes_ += entry.num_bytes;
  entries_.push_front(std::move(entry));
  while (num_bytes_ > max_bytes_ && entries_.size() > 1) {
    num_bytes_ -= entries_.back().num_bytes;
    entries_.pop_back();
  }
}

std::shared_ptr<const SiteMap> MapCache::Get(const Storage& storage,
                                             const std::string& site_id,
                                             int64_t updated_at_us) {
  const std::string key = site_id + "@" + std::to_string(updated_at_us);
  if (std::shared_ptr<const SiteMap> map = Find(key)) return map;
  const std::optional<std::string> blob = storage.ReadSiteMap(site_id);
  if (!blob) return nullptr;
  try {
    const auto map = std::make_shared<const SiteMap>(DeserializeSiteMap(*blob));
    const size_t num_cells =
        static_cast<size_t>(map->map.grid.num_rows) * static_cast<size_t>(map->map.grid.num_cols);
    Keep({key, num_cells * kBytesPerCell, map});
    return map;
  } catch (const std::runtime_error& error) {
    // One damaged map must not keep the others from an emergency.
    spdlog::error("map of site {}: {}", site_id, error.what());
    return nullptr;
  }
}

}  // namespace freelsd
