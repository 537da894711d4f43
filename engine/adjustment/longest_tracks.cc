#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

#include "engine/adjustment/adjustment.h"

namespace freelsd {
namespace {

// Parts of an image per axis, so that the kept tracks cover it.
constexpr int kNumParts = 5;

// Number of views by track.
using Lengths = std::map<int64_t, int>;

Lengths CountViews(const std::vector<View>& views) {
  Lengths lengths;
  for (const View& view : views) {
    for (const Observation& observation : view.observations) ++lengths[observation.track_id];
  }
  return lengths;
}

size_t PartOf(const Eigen::Vector2d& point_in_image, const Camera& camera) {
  const auto part = [](double px, int size_px) {
    return static_cast<size_t>(std::clamp(px / size_px * kNumParts, 0.0, kNumParts - 1.0));
  };
  return part(point_in_image.y(), camera.height_px) * kNumParts +
         part(point_in_image.x(), camera.width_px);
}

// The longest tracks in each part of the view's image; the oldest of equal ones.
void KeepLongest(const View& view,
                 const Camera& camera,
                 const Lengths& lengths,
                 size_t num_per_part,
                 std::set<int64_t>& kept) {
  std::array<std::vector<std::pair<int, int64_t>>, size_t{kNumParts} * kNumParts> parts;
  for (const Observation& observation : view.observations) {
    const int length = lengths.at(observation.track_id);
    if (length < 2 || !observation.point_in_image.allFinite()) continue;
    parts[PartOf(observation.point_in_image, camera)].emplace_back(-length, observation.track_id);
  }
  for (auto& part : parts) {
    const size_t num_kept = std::min(num_per_part, part.size());
    const auto end = part.begin() + static_cast<std::ptrdiff_t>(num_kept);
    std::partial_sort(part.begin(), end, part.end());
    for (auto it = part.begin(); it != end; ++it) kept.insert(it->second);
  }
}

}  // namespace

AdjustmentOptions InFlight(AdjustmentOptions options) {
  // The newest views often lie in one line. Their tilt is then poorly known, but not worse than
  // before. The backend checks the tilt again.
  options.max_tilt_sd_deg = 90.0;
  // Gusts within an image do not move regions, and each trial costs a solution.
  options.max_readout_power = std::min(options.max_readout_power, 2);
  return options;
}

std::vector<View> WithLongestTracks(std::vector<View> views, const Camera& camera, int num_tracks) {
  if (num_tracks <= 0) return views;
  constexpr int kNumInAll = kNumParts * kNumParts;
  const size_t num_per_part = static_cast<size_t>((num_tracks + kNumInAll - 1) / kNumInAll);
  const Lengths lengths = CountViews(views);
  std::set<int64_t> kept;
  for (const View& view : views) KeepLongest(view, camera, lengths, num_per_part, kept);
  for (View& view : views) {
    std::erase_if(view.observations, [&](const Observation& observation) {
      return !kept.contains(observation.track_id);
    });
  }
  return views;
}

}  // namespace freelsd
