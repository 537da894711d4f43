#include <utility>

#include "engine/selection/selection.h"

namespace freelsd {
namespace {

// The first round brings groups closer, so a second round can find more matches.
constexpr int kMaxNumRounds = 2;

std::vector<View> Posed(std::vector<View> views, const AdjustedBlock& block) {
  for (size_t i = 0; i < views.size(); ++i) {
    const AdjustedView& adjusted = block.views[i];
    views[i].world_from_camera = adjusted.world_from_camera;
    views[i].readout = adjusted.readout;
    views[i].height_above_ground = adjusted.height_above_ground;
  }
  return views;
}

size_t NumObservations(const std::vector<View>& views) {
  size_t count = 0;
  for (const View& view : views) count += view.observations.size();
  return count;
}

}  // namespace

AdjustedBlock AdjustAndTie(const std::vector<View>& views,
                           const Camera& camera,
                           const ImageSource& images,
                           const TracksOptions& tracks,
                           const AdjustmentOptions& options) {
  AdjustedBlock best = AdjustPoses(views, camera, options);
  std::vector<View> tied = views;
  for (int round = 0; round < kMaxNumRounds; ++round) {
    if (!best.is_usable || best.LargestGroup().size() == views.size()) return best;
    std::vector<int> group;
    for (const AdjustedView& view : best.views) group.push_back(view.group);
    const size_t num_before = NumObservations(tied);
    tied = TieOnGround(Posed(std::move(tied), best), group, best.camera, images, tracks);
    if (NumObservations(tied) == num_before) return best;
    AdjustedBlock block = AdjustPoses(tied, camera, options);
    if (block.LargestGroup().size() <= best.LargestGroup().size()) return best;
    best = std::move(block);
  }
  return best;
}

}  // namespace freelsd
