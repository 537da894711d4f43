// A cache of recently used values, limited in bytes.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

namespace freelsd {

// Not thread-safe.
template <typename Key, typename Value>
class Recent {
 public:
  explicit Recent(size_t max_bytes) : max_bytes_(max_bytes) {}

  // nullptr if there is none. Valid until the next change.
  const Value* Find(const Key& key) {
    const auto found = entries_.find(key);
    if (found == entries_.end()) return nullptr;
    found->second.last_use = ++num_uses_;
    return &found->second.value;
  }

  // Replaces any value of the key. Over the limit, the half that was used least recently goes:
  // dropping one value at a time would cost a search each time.
  void Keep(const Key& key, Value value, size_t num_bytes) {
    Entry& entry = entries_[key];
    num_bytes_ += num_bytes - entry.num_bytes;
    entry = {std::move(value), num_bytes, ++num_uses_};
    if (num_bytes_ > max_bytes_) DropHalf();
  }

 private:
  struct Entry {
    Value value;
    size_t num_bytes = 0;
    uint64_t last_use = 0;
  };

  void DropHalf() {
    std::vector<uint64_t> uses;
    for (const auto& [key, entry] : entries_) uses.push_back(entry.last_use);
    const auto middle = uses.begin() + static_cast<std::ptrdiff_t>(uses.size() / 2);
    std::nth_element(uses.begin(), middle, uses.end());
    std::erase_if(entries_, [&](const auto& each) { return each.second.last_use < *middle; });
    num_bytes_ = 0;
    for (const auto& [key, entry] : entries_) num_bytes_ += entry.num_bytes;
  }

  size_t max_bytes_;
  size_t num_bytes_ = 0;
  uint64_t num_uses_ = 0;
  std::map<Key, Entry> entries_;
};

}  // namespace freelsd
