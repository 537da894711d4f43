#include "engine/selection/selection.h"

namespace freelsd {

std::vector<KindView> AdjustedKindViews(const Snapshot& snapshot,
                                        const std::vector<size_t>& indices,
                                        const AdjustedBlock& block) {
  std::vector<KindView> views;
  for (size_t i = 0; i < indices.size(); ++i) {
    if (!block.views[i].is_connected) continue;
    views.push_back(
        {block.views[i].world_from_camera, block.CameraOf(i), snapshot.kinds[indices[i]]});
  }
  return views;
}

}  // namespace freelsd
