#include <algorithm>
#include <cmath>
#include <iterator>
#include <tuple>
#include <utility>

#include "engine/stereo/place_counts.h"
#include "engine/stereo/stereo.h"

namespace freelsd {
namespace {

int NumShared(const AdjustedView& a, const AdjustedView& b) {
  std::vector<size_t> shared;
  std::set_intersection(a.landmarks.begin(),
                        a.landmarks.end(),
                        b.landmarks.begin(),
                        b.landmarks.end(),
                        std::back_inserter(shared));
  return static_cast<int>(shared.size());
}

// Baseline, epipolar and viewing cost; nothing if the views form no pair.
std::optional<double> PairCost(const AdjustedView& a,
                               const AdjustedView& b,
                               const StereoOptions& options) {
  const int num_shared = NumShared(a, b);
  if (num_shared < options.min_num_shared_landmarks) return std::nullopt;
  const Eigen::Vector3d baseline =
      b.world_from_camera.translation - a.world_from_camera.translation;
  const Eigen::Vector3d axis_a = a.world_from_camera.rotation * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d axis_b = b.world_from_camera.rotation * Eigen::Vector3d::UnitZ();
  const double height = 0.5 * (a.height_above_ground + b.height_above_ground);
  const Eigen::Vector3d axis = (axis_a + axis_b).normalized();
  const double across = (baseline - axis * axis.dot(baseline)).norm();
  const double ratio = across / std::max(height, 1.0);
  if (ratio < options.min_baseline_ratio || ratio > options.max_baseline_ratio) {
    return std::nullopt;
  }
  const double angle_deg = DegFromRad(std::acos(std::clamp(axis_a.dot(axis_b), -1.0, 1.0)));
  if (angle_deg > options.max_axis_angle_deg) return std::nullopt;
  const double baseline_cost = std::abs(std::log(ratio / options.ideal_baseline_ratio));
  // Rows stay epipolar for any direction, but a baseline along the axis wastes resolution.
  const double epipolar_cost = std::abs(axis.dot(baseline)) / baseline.norm();
  const double viewing_cost = angle_deg / options.max_axis_angle_deg;
  const double overlap = static_cast<double>(num_shared) /
                         static_cast<double>(std::max(a.landmarks.size(), b.landmarks.size()));
  return baseline_cost + epipolar_cost + viewing_cost + (1.0 - overlap);
}

bool IsCheaper(const StereoPair& a, const StereoPair& b) {
  return std::tie(a.cost, a.left, a.right) < std::tie(b.cost, b.left, b.right);
}

// The cheapest pairs of each view.
std::vector<StereoPair> PartnersOf(const std::vector<StereoPair>& by_cost,
                                   size_t num_views,
                                   int num_partners) {
  std::vector<int> num_of(num_views, 0);
  std::vector<StereoPair> partners;
  for (const StereoPair& pair : by_cost) {
    const bool is_wanted = num_of[pair.left] < num_partners || num_of[pair.right] < num_partners;
    ++num_of[pair.left];
    ++num_of[pair.right];
    if (is_wanted) partners.push_back(pair);
  }
  return partners;
}

}  // namespace

std::vector<StereoPair> SelectPairs(const AdjustedBlock& block, const StereoOptions& options) {
  std::vector<StereoPair> candidates;
  for (size_t i = 0; i < block.views.size(); ++i) {
    if (!block.views[i].is_connected) continue;
    for (size_t j = i + 1; j < block.views.size(); ++j) {
      if (!block.views[j].is_connected) continue;
      if (const auto cost = PairCost(block.views[i], block.views[j], options)) {
        candidates.push_back({i, j, *cost});
      }
    }
  }
  std::sort(candidates.begin(), candidates.end(), IsCheaper);
  std::vector<StereoPair> pairs = PartnersOf(candidates, block.views.size(), options.num_partners);
  if (options.num_pairs_per_place > 0) {
    PlaceCounts counts(block);
    for (const StereoPair& pair : pairs) counts.Add(pair);
    std::vector<StereoPair> others;
    std::set_difference(candidates.begin(),
                        candidates.end(),
                        pairs.begin(),
                        pairs.end(),
                        std::back_inserter(others),
                        IsCheaper);
    for (const StereoPair& pair : others) {
      const double needed = counts.NeededRatio(pair, options.num_pairs_per_place);
      if (needed <= 0.0 || needed < options.min_needed_ratio) continue;
      counts.Add(pair);
      pairs.push_back(pair);
    }
  }
  // Pairs of one view are consecutive, so that its image is read once.
  std::sort(pairs.begin(), pairs.end(), [](const auto& a, const auto& b) {
    return a.left != b.left ? a.left < b.left : a.right < b.right;
  });
  return pairs;
}

}  // namespace freelsd
