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

// The block adjusted again, with its sightings aligned at full resolution.
AdjustedBlock Aligned(const std::vector<View>& views,
                      const AdjustedBlock& block,
                      const Camera& camera,
                      const ImageSource& images,
                      const TracksOptions& tracks,
                      const AdjustmentOptions& options) {
  const bool is_reduced = camera.width_px > tracks.matching_width_px;
  if (!block.is_usable || !is_reduced || tracks.max_alignment_shift_px == 0.0) return block;
  AdjustedBlock aligned = AdjustPoses(
      AlignSightings(Posed(views, block), block.camera, images, tracks), camera, options);
  aligned.rms_before_px = block.rms_before_px;
  const bool is_whole = aligned.LargestGroup().size() >= block.LargestGroup().size();
  return aligned.is_usable && is_whole ? aligned : block;
}

struct TiedBlock {
  // The observations with which the block was adjusted.
  std::vector<View> views;
  AdjustedBlock block;
};

TiedBlock Tied(const std::vector<View>& views,
               const Camera& camera,
               const ImageSource& images,
               const TracksOptions& tracks,
               const AdjustmentOptions& options) {
  TiedBlock best{views, AdjustPoses(views, camera, options)};
  for (int round = 0; round < kMaxNumRounds; ++round) {
    const AdjustedBlock& block = best.block;
    if (!block.is_usable || block.LargestGroup().size() == views.size()) return best;
    std::vector<int> group;
    for (const AdjustedView& view : block.views) group.push_back(view.group);
    std::vector<View> tied =
        TieOnGround(Posed(best.views, block), group, block.camera, images, tracks);
    if (NumObservations(tied) == NumObservations(best.views)) return best;
    AdjustedBlock tied_block = AdjustPoses(tied, camera, options);
    if (tied_block.LargestGroup().size() <= block.LargestGroup().size()) return best;
    best = {std::move(tied), std::move(tied_block)};
  }
  return best;
}

}  // namespace

AdjustedBlock AdjustAndTie(const std::vector<View>& views,
                           const Camera& camera,
                           const ImageSource& images,
                           const TracksOptions& tracks,
                           const AdjustmentOptions& options) {
  const TiedBlock tied = Tied(views, camera, images, tracks, options);
  return Aligned(tied.views, tied.block, camera, images, tracks, options);
}

}  // namespace freelsd
