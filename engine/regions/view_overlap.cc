#include <algorithm>
#include <cmath>

#include "engine/regions/region_update.h"

namespace freelsd {

void ViewOverlap::Add(size_t view,
                      const Eigen::Vector2d& center_in_world,
                      const Polygon& footprint) {
  if (!views_.insert(view).second) return;
  Entry added{.center_in_world = center_in_world, .footprint = footprint};
  for (Entry& entry : entries_) {
    if (Contains(footprint, entry.center_in_world)) ++entry.num_views;
    if (Contains(entry.footprint, center_in_world)) ++added.num_views;
  }
  entries_.push_back(std::move(added));
}

double ViewOverlap::ExpectedNumViews() const {
  if (entries_.empty()) return 0.0;
  std::vector<int> counts;
  for (const Entry& entry : entries_) counts.push_back(entry.num_views);
  const auto middle = counts.begin() + counts.size() / 2;
  std::nth_element(counts.begin(), middle, counts.end());
  return *middle;
}

int ViewOverlap::MinNumObservations(const RegionsOptions& options) const {
  const int half = static_cast<int>(std::ceil(0.5 * ExpectedNumViews()));
  return std::clamp(half, options.min_num_observations_floor, options.min_num_observations);
}

}  // namespace freelsd
