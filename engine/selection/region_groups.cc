#include <iterator>
#include <utility>

#include "engine/selection/selection.h"

namespace freelsd {
namespace {

using Regions = std::vector<Candidate>;

Box BoxOf(const Regions& regions) {
  Box box;
  for (const Candidate& candidate : regions) box.Add(candidate.region.Center().head<2>());
  return box;
}

Box PositionsOf(const Snapshot& snapshot) {
  Box box;
  for (const View& view : snapshot.views) box.Add(view.world_from_camera.translation.head<2>());
  return box;
}

bool IsNear(const Box& box, const BackendOptions& options) {
  return !((box.max - box.min).maxCoeff() > options.max_group_extent_m);
}

bool HasFewViews(const Snapshot& snapshot, const Box& area, const PipelineOptions& options) {
  const auto max_num_views = static_cast<size_t>(options.backend.max_num_views);
  return snapshot.views.size() <= max_num_views ||
         SelectViews(snapshot, area, options.adjustment, options.backend).num_seeing <=
             max_num_views;
}

// Splits across the middle of the longer side and keeps the given order. Neither half is empty,
// unless all regions share one place.
std::pair<Regions, Regions> Halves(const Regions& regions) {
  const Box box = BoxOf(regions);
  const Eigen::Vector2d extent = box.max - box.min, middle = 0.5 * (box.min + box.max);
  const int axis = extent.x() >= extent.y() ? 0 : 1;
  std::pair<Regions, Regions> halves;
  for (const Candidate& candidate : regions) {
    const bool is_first = candidate.region.Center()[axis] < middle[axis];
    (is_first ? halves.first : halves.second).push_back(candidate);
  }
  return halves;
}

std::vector<RegionGroup> Split(const Snapshot& snapshot,
                               const Regions& regions,
                               const PipelineOptions& options) {
  if (regions.empty()) return {};
  const RegionGroup whole{regions, AreaAround(regions, options.backend)};
  const bool is_small =
      IsNear(BoxOf(regions), options.backend) && HasFewViews(snapshot, whole.area, options);
  if (regions.size() == 1 || is_small) return {whole};
  const auto [first, second] = Halves(regions);
  if (first.empty() || second.empty()) return {whole};
  std::vector<RegionGroup> groups = Split(snapshot, first, options);
  std::vector<RegionGroup> others = Split(snapshot, second, options);
  groups.insert(
      groups.end(), std::make_move_iterator(others.begin()), std::make_move_iterator(others.end()));
  return groups;
}

}  // namespace

std::vector<RegionGroup> GroupRegions(const Snapshot& snapshot,
                                      const std::vector<Candidate>& regions,
                                      const PipelineOptions& options) {
  const Box photographed = PhotographedArea(snapshot);
  const bool is_one_map = !photographed.IsEmpty() &&
                          IsNear(PositionsOf(snapshot), options.backend) &&
                          HasFewViews(snapshot, photographed, options);
  if (is_one_map) return {{regions, photographed}};
  return Split(snapshot, regions, options);
}

}  // namespace freelsd
