// A cache of rows with bounding boxes. It answers from memory if no site has changed and the
// requested box lies within one that was read. This is usual, because an aircraft that asks for its
// surroundings moves little between two requests, and because a box grows to hold those of several
// aircraft near each other. Rows are shared, not copied.
#pragma once

#include <algorithm>
#include <functional>
#include <iterator>
#include <list>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "storage/boxes.h"
#include "storage/site_store.h"

namespace freelsd {

// A row and its bounding box, which may cross the antimeridian.
template <typename Row>
struct Boxed {
  BoundingBox box{};
  std::shared_ptr<const Row> row;
};

// Thread-safe.
template <typename Row>
class BoxCache {
 public:
  using Rows = std::vector<Boxed<Row>>;
  using Read = std::function<Rows(const BoundingBox& box)>;

  // Returns the rows whose boxes overlap `box`, which must not cross the antimeridian. The caller
  // gets `version` before this call. If rows change between the two calls, the next call reads them
  // again.
  SharedRows<Row> Within(const BoundingBox& box, uint64_t version, const Read& read) {
    std::shared_ptr<const FromSouth> kept = Find(box, version);
    if (!kept) {
      const BoundingBox wide = Grown(WithKept(box, version));
      kept = std::make_shared<const FromSouth>(read(wide));
      Keep({wide, version, kept});
    }
    SharedRows<Row> met;
    for (auto each = kept->First(box.south_deg);
         each != kept->rows.end() && each->box.south_deg <= box.north_deg;
         ++each) {
      if (Meets(each->box, box)) met.push_back(each->row);
    }
    return met;
  }

 private:
  // Rows sorted by their southern edge, so that only one strip is searched for a small box.
  struct FromSouth {
    explicit FromSouth(Rows read) : rows(std::move(read)) {
      std::stable_sort(rows.begin(), rows.end(), [](const Boxed<Row>& a, const Boxed<Row>& b) {
        return a.box.south_deg < b.box.south_deg;
      });
      for (const Boxed<Row>& each : rows) {
        tallest_deg = std::max(tallest_deg, each.box.north_deg - each.box.south_deg);
      }
    }
    // The first row that may extend as far north as `south_deg`.
    typename Rows::const_iterator First(double south_deg) const {
      return std::partition_point(rows.begin(), rows.end(), [&](const Boxed<Row>& each) {
        return each.box.south_deg + tallest_deg < south_deg;
      });
    }

    Rows rows;
    double tallest_deg = 0.0;
  };

  struct Part {
    BoundingBox box{};
    uint64_t version = 0;
    std::shared_ptr<const FromSouth> rows;
  };

  static constexpr size_t kMaxNumRowsTogether = 5000;
  // Some 100 MB of sites, and boxes of a thousand aircraft.
  static constexpr size_t kMaxNumRows = 100000;
  static constexpr size_t kMaxNumParts = 2000;

  static bool Holds(const BoundingBox& outer, const BoundingBox& inner) {
    return inner.west_deg >= outer.west_deg && inner.east_deg <= outer.east_deg &&
           inner.south_deg >= outer.south_deg && inner.north_deg <= outer.north_deg;
  }

  std::shared_ptr<const FromSouth> Find(const BoundingBox& box, uint64_t version) {
    const std::lock_guard lock(mutex_);
    const auto found = std::find_if(parts_.begin(), parts_.end(), [&](const Part& part) {
      return part.version == version && Holds(part.box, box);
    });
    if (found == parts_.end()) return nullptr;
    parts_.splice(parts_.begin(), parts_, found);
    return found->rows;
  }

  // The box, or one that also holds a kept one, if that costs little.
  BoundingBox WithKept(const BoundingBox& box, uint64_t version) {
    constexpr double kMaxDeg = 1.0;
    const std::lock_guard lock(mutex_);
    for (const Part& part : parts_) {
      if (part.version != version || part.rows->rows.size() > kMaxNumRowsTogether) continue;
      const BoundingBox both{std::min(box.west_deg, part.box.west_deg),
                             std::min(box.south_deg, part.box.south_deg),
                             std::max(box.east_deg, part.box.east_deg),
                             std::max(box.north_deg, part.box.north_deg)};
      const bool is_small =
          both.east_deg - both.west_deg <= kMaxDeg && both.north_deg - both.south_deg <= kMaxDeg;
      if (is_small) return both;
    }
    return box;
  }

  // Drops what it replaces, and the least recently used.
  void Keep(Part part) {
    const std::lock_guard lock(mutex_);
    parts_.remove_if([&part](const Part& old) {
      return old.version < part.version ||
             (old.version == part.version && Holds(part.box, old.box));
    });
    parts_.push_front(std::move(part));
    size_t num_rows = 0, num_parts = 0;
    const auto first_too_many = std::find_if(parts_.begin(), parts_.end(), [&](const Part& each) {
      num_rows += each.rows->rows.size();
      return ++num_parts > kMaxNumParts || (num_parts > 1 && num_rows > kMaxNumRows);
    });
    parts_.erase(first_too_many, parts_.end());
  }

  // Enlarges the box by a quarter of its size, but at least 0.02 degrees, on each side.
  static BoundingBox Grown(const BoundingBox& box) {
    constexpr double kLeastDeg = 0.02;
    const double dlon_deg = std::max(kLeastDeg, 0.25 * (box.east_deg - box.west_deg));
    const double dlat_deg = std::max(kLeastDeg, 0.25 * (box.north_deg - box.south_deg));
    return {std::max(-180.0, box.west_deg - dlon_deg),
            std::max(-90.0, box.south_deg - dlat_deg),
            std::min(180.0, box.east_deg + dlon_deg),
            std::min(90.0, box.north_deg + dlat_deg)};
  }

  // Guards parts_.
  std::mutex mutex_;
  // The most recently used first.
  std::list<Part> parts_;
};

inline const std::string& IdOf(const RecallRow& row) { return row.site_id; }
inline const std::string& IdOf(const MapRow& row) { return row.id; }
inline const std::string& IdOf(const std::string& id) { return id; }

// Reads the rows within the box through the cache, each once. The box may cross the antimeridian.
template <typename Row>
SharedRows<Row> RowsWithin(BoxCache<Row>& cache,
                           const BoundingBox& box,
                           uint64_t version,
                           const typename BoxCache<Row>::Read& read) {
  SharedRows<Row> rows;
  const std::vector<BoundingBox> parts = PlainBoxes(box);
  for (const BoundingBox& part : parts) {
    SharedRows<Row> some = cache.Within(part, version, read);
    std::move(some.begin(), some.end(), std::back_inserter(rows));
  }
  if (parts.size() > 1) {
    std::set<std::string> ids;
    std::erase_if(rows, [&ids](const auto& row) { return !ids.insert(IdOf(*row)).second; });
  }
  return rows;
}

}  // namespace freelsd
