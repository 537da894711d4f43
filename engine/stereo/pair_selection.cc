#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

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

}  // namespace

std::vector<StereoPair> SelectPairs(const AdjustedBlock& block, const StereoOptions& options) {
  std::set<std::pair<size_t, size_t>> taken;
  std::vector<StereoPair> pairs;
  for (size_t i = 0; i < block.views.size(); ++i) {
    if (!block.views[i].is_connected) continue;
    std::vector<StereoPair> partners;
    for (size_t j = 0; j < block.views.size(); ++j) {
      if (j == i || !block.views[j].is_connected) continue;
      if (const auto cost = PairCost(block.views[i], block.views[j], options)) {
        partners.push_back({std::min(i, j), std::max(i, j), *cost});
      }
    }
    std::stable_sort(partners.begin(), partners.end(), [](const auto& a, const auto& b) {
      return a.cost < b.cost;
    });
    partners.resize(std::min(partners.size(), static_cast<size_t>(options.num_partners)));
    for (const StereoPair& pair : partners) {
      if (taken.insert({pair.left, pair.right}).second) pairs.push_back(pair);
    }
  }
  // Pairs of one view are consecutive, so that its image is read once.
  std::stable_sort(pairs.begin(), pairs.end(), [](const auto& a, const auto& b) {
    return a.left != b.left ? a.left < b.left : a.right < b.right;
  });
  return pairs;
}

}  // namespace freelsd
