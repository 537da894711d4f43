#include "engine/heights/view_choice.h"

#include <algorithm>
#include <limits>
#include <map>

namespace freelsd {
namespace {

std::vector<size_t> OfLargestGroup(const AdjustedBlock& block, const std::vector<size_t>& views) {
  std::map<int, std::vector<size_t>> groups;
  for (const size_t view : views) groups[block.views[view].group].push_back(view);
  std::vector<size_t> largest;
  for (const auto& [group, members] : groups) {
    if (members.size() > largest.size()) largest = members;
  }
  return largest;
}

Eigen::Vector2d CameraOf(const AdjustedBlock& block, size_t view) {
  return block.views[view].world_from_camera.translation.head<2>();
}

}  // namespace

ChosenViews ChooseViews(const AdjustedBlock& block,
                        const std::vector<size_t>& seeing,
                        const Eigen::Vector3d& place_in_world,
                        int max_num_views) {
  ChosenViews chosen;
  const std::vector<size_t> views = OfLargestGroup(block, seeing);
  if (views.empty()) return chosen;
  const Eigen::Vector2d place = place_in_world.head<2>();
  size_t next = *std::min_element(views.begin(), views.end(), [&](size_t a, size_t b) {
    return (CameraOf(block, a) - place).squaredNorm() < (CameraOf(block, b) - place).squaredNorm();
  });
  std::vector<double> distance(views.size(), std::numeric_limits<double>::infinity());
  double widest = 0.0;
  while (true) {
    chosen.views.push_back(next);
    for (size_t i = 0; i < views.size(); ++i) {
      const double apart = (CameraOf(block, views[i]) - CameraOf(block, next)).norm();
      distance[i] = std::min(distance[i], apart);
      const bool is_chosen = distance[i] <= 0.0;
      if (is_chosen) widest = std::max(widest, apart);
    }
    const auto farthest = std::max_element(distance.begin(), distance.end());
    if (*farthest <= 0.0 || chosen.views.size() >= static_cast<size_t>(max_num_views)) break;
    next = views[static_cast<size_t>(farthest - distance.begin())];
  }
  const double above =
      block.views[chosen.views.front()].world_from_camera.translation.z() - place_in_world.z();
  chosen.baseline_ratio = widest / std::max(above, 1.0);
  std::sort(chosen.views.begin(), chosen.views.end());
  return chosen;
}

}  // namespace freelsd
