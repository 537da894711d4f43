#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/selection/selection.h"

namespace freelsd {
namespace {

// Place on the ground in the middle of a view, and the radius that the view sees.
struct Footprint {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  double radius = 0.0;
};

Footprint FootprintOf(const View& view, const Camera& camera) {
  const Eigen::Vector3d axis = view.world_from_camera.rotation * Eigen::Vector3d::UnitZ();
  // At most 70 deg off nadir: an axis near the horizon would put the centre anywhere.
  constexpr double kMinDescent = 0.34;
  const double along = view.height_above_ground / std::max(-axis.z(), kMinDescent);
  const double diagonal_px = std::hypot(camera.width_px, camera.height_px);
  return {(view.world_from_camera.translation + axis * along).head<2>(),
          0.5 * diagonal_px / camera.MeanFocalPx() * along};
}

}  // namespace

void Box::Add(const Eigen::Vector2d& point) {
  min = min.cwiseMin(point);
  max = max.cwiseMax(point);
}

void Box::Grow(double margin) {
  min.array() -= margin;
  max.array() += margin;
}

bool Box::IsEmpty() const { return !(min.array() < max.array()).all(); }

double Box::DistanceTo(const Eigen::Vector2d& point) const {
  return (point - point.cwiseMax(min).cwiseMin(max)).norm();
}

Box Box::Intersection(const Box& other) const {
  return {min.cwiseMax(other.min), max.cwiseMin(other.max)};
}

Box AreaAround(const std::vector<Candidate>& regions, const BackendOptions& options) {
  Box area;
  for (const auto& [region, wind] : regions) {
    for (const Eigen::Vector2d& corner : region.Footprint()) area.Add(corner);
  }
  area.Grow(options.max_surroundings_m);
  return area;
}

Box PhotographedArea(const Snapshot& snapshot) {
  Box area;
  for (const View& view : snapshot.views) {
    const Footprint footprint = FootprintOf(view, snapshot.rig.camera);
    const Eigen::Vector2d radius = Eigen::Vector2d::Constant(footprint.radius);
    area.Add(footprint.center - radius);
    area.Add(footprint.center + radius);
  }
  return area;
}

Selection SelectViews(const Snapshot& snapshot,
                      const Box& area,
                      const AdjustmentOptions& adjustment,
                      const BackendOptions& options) {
  const Camera& camera = snapshot.rig.camera;
  std::vector<size_t> seeing;
  std::vector<View> views;
  for (size_t i = 0; i < snapshot.views.size(); ++i) {
    const Footprint footprint = FootprintOf(snapshot.views[i], camera);
    if (area.DistanceTo(footprint.center) > footprint.radius) continue;
    seeing.push_back(i);
    views.push_back(snapshot.views[i]);
  }
  // Sorted by distance from the middle, so that each view keeps a neighbour.
  const Eigen::Vector2d middle = 0.5 * (area.min + area.max);
  std::vector<std::pair<double, size_t>> nearest;
  for (const size_t keyframe : SelectKeyframes(views, adjustment)) {
    const Footprint footprint = FootprintOf(views[keyframe], camera);
    nearest.emplace_back((footprint.center - middle).norm(), keyframe);
  }
  Selection selection;
  selection.num_seeing = nearest.size();
  std::sort(nearest.begin(), nearest.end());
  nearest.resize(std::min(nearest.size(), static_cast<size_t>(options.max_num_views)));
  std::sort(nearest.begin(), nearest.end(), [](const auto& left, const auto& right) {
    return left.second < right.second;
  });
  for (const auto& [distance, keyframe] : nearest) {
    selection.indices.push_back(seeing[keyframe]);
    selection.views.push_back(std::move(views[keyframe]));
  }
  return selection;
}

Box SeenArea(const AdjustedBlock& block) {
  Box seen;
  for (const Landmark& landmark : block.landmarks) seen.Add(landmark.point_in_world.head<2>());
  // Dense matching reaches a little beyond the outermost tracked corner.
  constexpr double kBeyondLandmarks = 25.0;
  seen.Grow(kBeyondLandmarks);
  return seen;
}

}  // namespace freelsd
