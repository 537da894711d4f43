#include <algorithm>
#include <set>

#include "engine/adjustment/adjustment.h"

namespace freelsd {
namespace {

std::set<int64_t> TrackIds(const View& view) {
  std::set<int64_t> ids;
  for (const Observation& observation : view.observations) ids.insert(observation.track_id);
  return ids;
}

int NumConnections(const std::set<int64_t>& keyframe, const View& view) {
  return static_cast<int>(
      std::count_if(view.observations.begin(), view.observations.end(), [&](const auto& seen) {
        return keyframe.contains(seen.track_id);
      }));
}

double Baseline(const View& a, const View& b) {
  return (a.world_from_camera.translation - b.world_from_camera.translation).norm();
}

// True if the view must not be skipped, because it shares too few matches with the key-frame or is
// too far from it.
bool IsDue(const View& keyframe,
           const std::set<int64_t>& ids,
           const View& view,
           const AdjustmentOptions& options) {
  return NumConnections(ids, view) < options.min_num_track_connections ||
         Baseline(keyframe, view) > options.max_baseline_ratio * view.height_above_ground;
}

}  // namespace

std::vector<size_t> SelectKeyframes(const std::vector<View>& views,
                                    const AdjustmentOptions& options) {
  std::vector<size_t> keyframes;
  if (views.empty()) return keyframes;
  keyframes.push_back(0);
  std::set<int64_t> ids = TrackIds(views[0]);
  for (size_t i = 1; i < views.size(); ++i) {
    const View& keyframe = views[keyframes.back()];
    if (!IsDue(keyframe, ids, views[i], options)) continue;
    // The predecessor of the first view that is due. Survey photographs are due at once, so the
    // view itself follows.
    size_t next = i - 1 > keyframes.back() ? i - 1 : i;
    if (Baseline(keyframe, views[next]) < options.min_baseline_m) next = i;
    if (Baseline(keyframe, views[next]) < options.min_baseline_m) continue;
    keyframes.push_back(next);
    ids = TrackIds(views[next]);
    i = next;
  }
  // Otherwise the ground of the last views would be lost.
  const size_t last = views.size() - 1;
  if (Baseline(views[keyframes.back()], views[last]) >= options.min_baseline_m) {
    keyframes.push_back(last);
  }
  return keyframes;
}

}  // namespace freelsd
