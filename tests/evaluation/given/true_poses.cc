#include "tests/evaluation/given/true_poses.h"

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "engine/geometry/triangulation.h"

namespace freelsd {
namespace {

// Indices of the views, by landmark.
std::vector<std::vector<size_t>> ViewsOfLandmarks(const AdjustedBlock& block) {
  std::vector<std::vector<size_t>> views(block.landmarks.size());
  for (size_t i = 0; i < block.views.size(); ++i) {
    for (const size_t landmark : block.views[i].landmarks) views[landmark].push_back(i);
  }
  return views;
}

// Where the landmark appears, as far as the residuals of the adjustment are small, seen from where
// the camera truly was.
std::vector<PosedRay> TrueRays(const AdjustedBlock& estimated,
                               const AdjustedBlock& with_true_poses,
                               const Eigen::Vector3d& point_in_world,
                               const std::vector<size_t>& views) {
  std::vector<PosedRay> rays;
  for (const size_t view : views) {
    const auto pixel = estimated.CameraOf(view).ImageFromCamera(
        Inverse(estimated.views[view].world_from_camera) * point_in_world);
    if (!pixel) continue;
    rays.push_back({with_true_poses.views[view].world_from_camera,
                    with_true_poses.CameraOf(view).NormalizedFromImage(*pixel)});
  }
  return rays;
}

// As the first view moves it, where the rays do not meet.
Eigen::Vector3d MovedWith(const AdjustedView& estimated,
                          const AdjustedView& with_true_pose,
                          const Eigen::Vector3d& point_in_world) {
  return with_true_pose.world_from_camera * (Inverse(estimated.world_from_camera) * point_in_world);
}

}  // namespace

AdjustedBlock WithTruePoses(AdjustedBlock block, const Scenario& scenario) {
  const AdjustedBlock estimated = block;
  std::map<std::string, size_t> exposure_of_id;
  for (size_t i = 0; i < scenario.exposures.size(); ++i) {
    exposure_of_id[scenario.exposures[i].image] = i;
  }
  block.camera = scenario.rig.camera;
  block.position_sd_m = block.tilt_sd_deg = 0.0;
  for (AdjustedView& view : block.views) {
    view.world_from_camera = scenario.TrueWorldFromCamera(exposure_of_id.at(view.frame_id));
    view.position_sd_m = 0.0;
    if (view.is_connected) view.group = 0;
  }
  const std::vector<std::vector<size_t>> views = ViewsOfLandmarks(estimated);
  for (size_t i = 0; i < block.landmarks.size(); ++i) {
    if (views[i].empty()) continue;
    Eigen::Vector3d& point_in_world = block.landmarks[i].point_in_world;
    const auto met = Triangulate(TrueRays(estimated, block, point_in_world, views[i]));
    const size_t first = views[i].front();
    point_in_world = met ? met->point_in_world
                         : MovedWith(estimated.views[first], block.views[first], point_in_world);
  }
  return block;
}

}  // namespace freelsd
