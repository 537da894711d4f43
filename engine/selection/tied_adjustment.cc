#include <algorithm>
#include <cmath>
#include <optional>
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

TrackPoints PointsOf(const AdjustedBlock& block) {
  TrackPoints points;
  for (const Landmark& landmark : block.landmarks) {
    points[landmark.track_id] = landmark.point_in_world;
  }
  return points;
}

// A sighting that an adjustment does not use, by which it is judged.
struct HeldOut {
  size_t view = 0;
  Observation sighting;
};

// Takes every tenth of the sightings that `tied` has beyond those of `views`.
std::vector<HeldOut> HoldOut(const std::vector<View>& views, std::vector<View>& tied) {
  constexpr size_t kInterval = 10;
  std::vector<HeldOut> held;
  for (size_t i = 0; i < views.size(); ++i) {
    std::vector<Observation>& sightings = tied[i].observations;
    std::vector<Observation> kept;
    for (size_t k = 0; k < sightings.size(); ++k) {
      const bool is_held = k >= views[i].observations.size() && (k + i) % kInterval == 0;
      if (is_held) {
        held.push_back({i, sightings[k]});
      } else {
        kept.push_back(sightings[k]);
      }
    }
    sightings = std::move(kept);
  }
  return held;
}

// Median distance from where the block shows the points of the sightings, px; nothing without any.
std::optional<double> MedianError(const AdjustedBlock& block, const std::vector<HeldOut>& held) {
  const TrackPoints points = PointsOf(block);
  std::vector<double> errors_px;
  for (const HeldOut& each : held) {
    const auto point = points.find(each.sighting.track_id);
    if (point == points.end()) continue;
    const Rigid3d& world_from_camera = block.views[each.view].world_from_camera;
    const auto shown =
        block.CameraOf(each.view).ImageFromCamera(Inverse(world_from_camera) * point->second);
    if (shown) errors_px.push_back((*shown - each.sighting.point_in_image).norm());
  }
  if (errors_px.empty()) return std::nullopt;
  const auto middle = errors_px.begin() + static_cast<std::ptrdiff_t>(errors_px.size() / 2);
  std::nth_element(errors_px.begin(), middle, errors_px.end());
  return *middle;
}

// Distance of the positions from their priors, in deviations of these, root mean square per axis.
double PriorMisfit(const AdjustedBlock& block, const std::vector<View>& views) {
  double sum = 0.0;
  for (size_t i = 0; i < views.size(); ++i) {
    sum += (block.views[i].world_from_camera.translation - views[i].prior_position_in_world)
               .squaredNorm() /
           (3.0 * std::pow(views[i].position_sd_m, 2));
  }
  return std::sqrt(sum / static_cast<double>(views.size()));
}

// Whether ties made a better block: no view is lost, sightings that neither block has used fit at
// least as well, and the positions fit their priors as well as before or as these allow.
bool IsBetter(const AdjustedBlock& tied,
              const AdjustedBlock& before,
              const std::vector<View>& views,
              const std::vector<HeldOut>& held) {
  if (tied.LargestGroup().size() < before.LargestGroup().size()) return false;
  const auto error_tied = MedianError(tied, held), error_before = MedianError(before, held);
  if (!error_tied || !error_before || *error_tied > *error_before) return false;
  return PriorMisfit(tied, views) <= std::max(1.0, PriorMisfit(before, views));
}

// Ties the views of one block along the whole length of their strips, not by hinges where the
// aircraft turned.
TiedBlock TiedAcross(TiedBlock tied,
                     const Camera& camera,
                     const ImageSource& images,
                     const TracksOptions& tracks,
                     const AdjustmentOptions& options) {
  const AdjustedBlock& before = tied.block;
  if (!before.is_usable || tracks.num_tie_points == 0) return tied;
  const std::vector<View> posed = Posed(tied.views, before);
  std::vector<View> views =
      FollowIntoOverlaps(posed, PointsOf(before), before.camera, images, tracks);
  const std::vector<HeldOut> held = HoldOut(posed, views);
  if (held.empty()) return tied;
  AdjustedBlock block = AdjustPoses(views, camera, options);
  if (!block.is_usable || !IsBetter(block, before, views, held)) return tied;
  block.rms_before_px = before.rms_before_px;
  return {std::move(views), std::move(block)};
}

}  // namespace

AdjustedBlock AdjustAndTie(const std::vector<View>& views,
                           const Camera& camera,
                           const ImageSource& images,
                           const TracksOptions& tracks,
                           const AdjustmentOptions& options) {
  const TiedBlock tied =
      TiedAcross(Tied(views, camera, images, tracks, options), camera, images, tracks, options);
  return Aligned(tied.views, tied.block, camera, images, tracks, options);
}

}  // namespace freelsd
