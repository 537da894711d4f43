// Rows with a box each, kept while no site changes and what is asked for lies within what was read:
// an aircraft that asks for its surroundings moves little between two requests. Thread-safe.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "storage/storage.h"

namespace freelsd {

template <typename Row>
struct Boxed {
  BoundingBox box{};
  Row row;
};

inline bool Meets(const BoundingBox& a, const BoundingBox& b) {
  return a.west_deg <= b.east_deg && a.east_deg >= b.west_deg && a.south_deg <= b.north_deg &&
         a.north_deg >= b.south_deg;
}

template <typename Row>
class BoxCache {
 public:
  using Rows = std::vector<Boxed<Row>>;
  using Read = std::function<Rows(const BoundingBox& box)>;

  // Rows whose boxes meet this one, which does not cross the antimeridian. `version`: read before
  // any row is, so that rows that are newer are at worst read twice.
  std::vector<Row> Within(const BoundingBox& box, uint64_t version, const Read& read) {
    std::shared_ptr<const Rows> rows = Kept(box, version);
    if (!rows) {
      const BoundingBox wide = Grown(box);
      rows = std::make_shared<const Rows>(read(wide));
      const std::lock_guard lock(mutex_);
      box_ = wide;
      version_ = version;
      kept_ = rows;
    }
    std::vector<Row> met;
    for (const Boxed<Row>& each : *rows) {
      if (Meets(each.box, box)) met.push_back(each.row);
    }
    return met;
  }

 private:
  std::shared_ptr<const Rows> Kept(const BoundingBox& box, uint64_t version) {
    const std::lock_guard lock(mutex_);
    const bool holds = kept_ && version_ == version && box.west_deg >= box_.west_deg &&
                       box.east_deg <= box_.east_deg && box.south_deg >= box_.south_deg &&
                       box.north_deg <= box_.north_deg;
    return holds ? kept_ : nullptr;
  }

  // By a quarter to each side, and at least by some two kilometres.
  static BoundingBox Grown(const BoundingBox& box) {
    constexpr double kLeastDeg = 0.02;
    const double dlon_deg = std::max(kLeastDeg, 0.25 * (box.east_deg - box.west_deg));
    const double dlat_deg = std::max(kLeastDeg, 0.25 * (box.north_deg - box.south_deg));
    return {std::max(-180.0, box.west_deg - dlon_deg),
            std::max(-90.0, box.south_deg - dlat_deg),
            std::min(180.0, box.east_deg + dlon_deg),
            std::min(90.0, box.north_deg + dlat_deg)};
  }

  std::mutex mutex_;
  uint64_t version_ = 0;
  BoundingBox box_{};
  std::shared_ptr<const Rows> kept_;
};

}  // namespace freelsd
