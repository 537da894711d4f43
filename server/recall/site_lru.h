// A least-recently-used cache with one value for each site, limited in bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>

namespace freelsd {

// Not thread-safe.
template <typename Value>
class SiteLru {
 public:
  explicit SiteLru(size_t max_bytes) : max_bytes_(max_bytes) {}

  // The site's value; nullptr if there is none, or if its update differs from `updated_at_us`. The
  // pointer is valid until the next change. Updates are compared only for equality, because clocks
  // can be set back.
  Value* Find(const std::string& site_id, std::optional<int64_t> updated_at_us = std::nullopt) {
    const auto found = entry_of_.find(site_id);
    if (found == entry_of_.end()) return nullptr;
    const auto entry = found->second;
    if (updated_at_us && entry->updated_at_us != *updated_at_us) return nullptr;
    entries_.splice(entries_.begin(), entries_, entry);
    return &entry->value;
  }

  // Replaces any value of the site. Then removes the least recently used values until the limit
  // holds, but never the new value.
  void Keep(const std::string& site_id, int64_t updated_at_us, size_t num_bytes, Value value) {
    Erase(site_id);
    num_bytes_ += num_bytes;
    entries_.push_front({site_id, updated_at_us, num_bytes, std::move(value)});
    entry_of_[site_id] = entries_.begin();
    while (num_bytes_ > max_bytes_ && entries_.size() > 1) {
      num_bytes_ -= entries_.back().num_bytes;
      entry_of_.erase(entries_.back().site_id);
      entries_.pop_back();
    }
  }

  void Erase(const std::string& site_id) {
    const auto found = entry_of_.find(site_id);
    if (found == entry_of_.end()) return;
    num_bytes_ -= found->second->num_bytes;
    entries_.erase(found->second);
    entry_of_.erase(found);
  }

 private:
  struct Entry {
    std::string site_id;
    int64_t updated_at_us = 0;
    size_t num_bytes = 0;
    Value value;
  };

  size_t max_bytes_;
  size_t num_bytes_ = 0;
  // The most recently used entry is first.
  std::list<Entry> entries_;
  std::unordered_map<std::string, typename std::list<Entry>::iterator> entry_of_;
};

}  // namespace freelsd
