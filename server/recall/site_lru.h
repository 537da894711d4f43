// A least-recently-used cache with one value for each site, limited in bytes.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <list>
#include <optional>
#include <string>
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
    const auto found = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& each) {
      return each.site_id == site_id && (!updated_at_us || each.updated_at_us == *updated_at_us);
    });
    if (found == entries_.end()) return nullptr;
    entries_.splice(entries_.begin(), entries_, found);
    return &found->value;
  }

  // Replaces any value of the site. Then removes the least recently used values until the limit
  // holds, but never the new value.
  void Keep(const std::string& site_id, int64_t updated_at_us, size_t num_bytes, Value value) {
    Erase(site_id);
    num_bytes_ += num_bytes;
    entries_.push_front({site_id, updated_at_us, num_bytes, std::move(value)});
    while (num_bytes_ > max_bytes_ && entries_.size() > 1) {
      num_bytes_ -= entries_.back().num_bytes;
      entries_.pop_back();
    }
  }

  void Erase(const std::string& site_id) {
    std::erase_if(entries_, [&](const Entry& each) {
      if (each.site_id != site_id) return false;
      num_bytes_ -= each.num_bytes;
      return true;
    });
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
};

}  // namespace freelsd
