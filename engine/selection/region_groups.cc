#include <iterator>
#include <utility>

#include "engine/selection/selection.h"

namespace freelsd {
namespace {

using Group = std::vector<Candidate>;

Box BoxOf(const Group& regions) {
  Box box;
  for (const Candidate& candidate : regions) box.Add(candidate.region.Center().head<2>());
  return box;
}

// Splits across the middle of the longer side and keeps the given order. Neither half is empty,
// unless all regions share one place.
std::pair<Group, Group> Halves(const Group& regions) {
  const Box box = BoxOf(regions);
  const Eigen::Vector2d extent = box.max - box.min, middle = 0.5 * (box.min + box.max);
  const int axis = extent.x() >= extent.y() ? 0 : 1;
  std::pair<Group, Group> halves;
  for (const Candidate& candidate : regions) {
    const bool is_first = candidate.region.Center()[axis] < middle[axis];
    (is_first ? halves.first : halves.second).push_back(candidate);
  }
  return halves;
}

}  // namespace

std::vector<Group> GroupRegions(const Snapshot& snapshot,
                                const Group& regions,
                                const Aircraft& aircraft,
                                const PipelineOptions& options) {
  if (regions.empty()) return {};
  const Box box = BoxOf(regions);
  const bool is_near = (box.max - box.min).maxCoeff() <= options.backend.max_group_extent_m;
  const size_t max_num_views = static_cast<size_t>(options.backend.max_num_views);
  const auto has_few_views = [&] {
    if (snapshot.views.size() <= max_num_views) return true;
    const Box area = AreaOfInterest(regions, aircraft, options.approach, options.backend);
    return SelectViews(snapshot, area, options.adjustment, options.backend).num_seeing <=
           max_num_views;
  };
  if (regions.size() == 1 || (is_near && has_few_views())) return {regions};
  const auto [first, second] = Halves(regions);
  if (first.empty() || second.empty()) return {regions};
  std::vector<Group> groups = GroupRegions(snapshot, first, aircraft, options);
  std::vector<Group> others = GroupRegions(snapshot, second, aircraft, options);
  groups.insert(
      groups.end(), std::make_move_iterator(others.begin()), std::make_move_iterator(others.end()));
  return groups;
}

}  // namespace freelsd
