// Cameras that look straight down on painted ground, and a level map below them.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine/cover/cover.h"
#include "tests/engine/stereo/scene.h"

namespace freelsd::above {

constexpr double kHeightM = 60.0;

using Paint = std::function<cv::Vec3b(const Eigen::Vector2d& place_in_world)>;

// Level ground at 0 about the origin.
inline ElevationMap LevelMap(int num_cells, double cell_size_m = 1.0) {
  ElevationMap map;
  const double half_m = 0.5 * num_cells * cell_size_m;
  map.grid = {{-half_m, half_m}, cell_size_m, num_cells, num_cells};
  map.elevation = cv::Mat1f(num_cells, num_cells, 0.0f);
  map.upper = cv::Mat1f(num_cells, num_cells, 0.1f);
  map.standard_deviation = cv::Mat1f(num_cells, num_cells, 0.1f);
  map.num_points = cv::Mat1f(num_cells, num_cells, 50.0f);
  return map;
}

inline AdjustedBlock BlockOf(const std::vector<Rigid3d>& world_from_camera) {
  AdjustedBlock block;
  block.camera = SceneCamera();
  block.is_usable = true;
  for (const Rigid3d& pose : world_from_camera) {
    AdjustedView view;
    view.frame_id = std::to_string(block.views.size());
    view.world_from_camera = pose;
    view.height_above_ground = pose.translation.z();
    view.is_connected = true;
    block.views.push_back(view);
  }
  return block;
}

// Colour of what a ray from the eye meets.
using RayPaint = std::function<cv::Vec3b(const Eigen::Vector3d& eye, const Eigen::Vector3d& ray)>;

inline Eigen::Vector2d AtHeight(const Eigen::Vector3d& eye,
                                const Eigen::Vector3d& ray,
                                double height) {
  return (eye - ray * ((eye.z() - height) / ray.z())).head<2>();
}

// What each view of the block shows.
inline ImageSource ImagesOfRays(const AdjustedBlock& block, const RayPaint& paint) {
  return [&block, paint](const std::string& frame_id) -> cv::Mat {
    const Rigid3d& world_from_camera = block.views[std::stoul(frame_id)].world_from_camera;
    cv::Mat3b image(block.camera.height_px, block.camera.width_px);
    for (int v = 0; v < image.rows; ++v) {
      for (int u = 0; u < image.cols; ++u) {
        image(v, u) =
            paint(world_from_camera.translation,
                  world_from_camera.rotation * block.camera.RayFromImage({double(u), double(v)}));
      }
    }
    return image;
  };
}

inline ImageSource ImagesOf(const AdjustedBlock& block, const Paint& paint) {
  return ImagesOfRays(block, [paint](const Eigen::Vector3d& eye, const Eigen::Vector3d& ray) {
    return paint(AtHeight(eye, ray, 0.0));
  });
}

inline std::vector<Rigid3d> TwoNadirViews() {
  return {SceneView({-10.0, 0.0, kHeightM}, 0.3), SceneView({10.0, 0.0, kHeightM}, 2.2)};
}

}  // namespace freelsd::above
