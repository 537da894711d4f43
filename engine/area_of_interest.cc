#include "engine/area_of_interest.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace freelsd {
namespace {

// Where a view sees the ground at its principal ray, and how far around it.
struct Footprint {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  double radius = 0.0;
};

Footprint FootprintOf(const View& view, const Camera& camera) {
  const Eigen::Vector3d axis = view.world_from_camera.rotation * Eigen::Vector3d::UnitZ();
  // An oblique axis near the horizon would put the centre anywhere: 70 deg off nadir at most.
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

Box AreaOfInterest(const std::vector<Region>& regions,
                   const Aircraft& aircraft,
                   double strongest_wind,
                   const BackendOptions& options) {
  Box area;
  for (const Region& region : regions) {
    for (const Eigen::Vector2d& corner : region.Footprint()) area.Add(corner);
  }
  double wanted = 0.0;
  for (const double wind_speed : {0.0, strongest_wind}) {
    const double final = std::max(0.0, ApproachDistance(aircraft, wind_speed));
    wanted = std::max(wanted, final + 2.0 * LoiterRadius(aircraft, wind_speed));
  }
  area.Grow(std::min(wanted, options.max_surroundings_m));
  return area;
}

std::vector<size_t> ViewsOf(const Snapshot& snapshot,
                            const Box& area,
                            const BackendOptions& options) {
  std::vector<std::pair<double, size_t>> near;
  for (size_t i = 0; i < snapshot.views.size(); ++i) {
    const Footprint footprint = FootprintOf(snapshot.views[i], snapshot.rig.camera);
    const double distance = area.DistanceTo(footprint.center);
    if (distance <= footprint.radius) near.emplace_back(distance, i);
  }
  std::stable_sort(near.begin(), near.end());
  near.resize(std::min(near.size(), static_cast<size_t>(options.max_num_views)));
  std::vector<size_t> indices;
  for (const auto& [distance, index] : near) indices.push_back(index);
  std::sort(indices.begin(), indices.end());
  return indices;
}

Box SeenArea(const AdjustedBlock& block) {
  Box seen;
  for (const Landmark& landmark : block.landmarks) seen.Add(landmark.point_in_world.head<2>());
  // Dense matching reaches a little beyond the outermost corner that was tracked.
  constexpr double kBeyondLandmarks = 25.0;
  seen.Grow(kBeyondLandmarks);
  return seen;
}

double StrongestWind(const std::vector<Region>& regions,
                     const Snapshot& snapshot,
                     const WindOptions& options) {
  double strongest = 0.0;
  for (const Region& region : regions) {
    const auto wind = WindAt(region.Center().head<2>(), snapshot.wind_samples, options);
    if (wind) strongest = std::max(strongest, wind->wind_in_world.norm());
  }
  return strongest;
}

}  // namespace freelsd
