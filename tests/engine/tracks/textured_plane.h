// Photographs of a level textured plane (world z = 0) by cameras of known pose.
#pragma once

#include <random>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/tracks/tracks.h"
#include "tests/engine/camera.h"

namespace freelsd {

inline Rig VideoRig() {
  Rig rig;
  rig.camera = CenteredCamera(752, 480, 465.0);
  return rig;
}

class TexturedPlane {
 public:
  // A square of ground around the world's origin; noise of several scales, seeded.
  explicit TexturedPlane(double half_width_m, unsigned seed = 1);
  cv::Mat Photograph(const Camera& camera, const Rigid3d& world_from_camera) const;

 private:
  static constexpr double kMetresPerPixel = 0.25;
  double half_width_m_;
  cv::Mat texture_;
};

inline TexturedPlane::TexturedPlane(double half_width_m, unsigned seed)
    : half_width_m_(half_width_m) {
  const int size = static_cast<int>(2.0 * half_width_m / kMetresPerPixel);
  cv::Mat sum = cv::Mat::zeros(size, size, CV_32F);
  cv::RNG generator(seed);
  for (const int cell_px : {3, 9, 30, 120}) {
    cv::Mat coarse(size / cell_px + 2, size / cell_px + 2, CV_32F), fine;
    generator.fill(coarse, cv::RNG::NORMAL, 0.0, 22.0);
    cv::resize(coarse, fine, sum.size(), 0.0, 0.0, cv::INTER_CUBIC);
    sum += fine;
  }
  sum.convertTo(texture_, CV_8U, 1.0, 128.0);
}

inline cv::Mat TexturedPlane::Photograph(const Camera& camera,
                                         const Rigid3d& world_from_camera) const {
  const Rigid3d camera_from_world = Inverse(world_from_camera);
  const Eigen::Matrix3d rotation = camera_from_world.rotation.toRotationMatrix();
  Eigen::Matrix3d image_from_camera, camera_from_plane, plane_from_texture;
  image_from_camera << camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1;
  camera_from_plane << rotation.col(0), rotation.col(1), camera_from_world.translation;
  plane_from_texture << kMetresPerPixel, 0, -half_width_m_, 0, -kMetresPerPixel, half_width_m_, 0,
      0, 1;
  const Eigen::Matrix3d image_from_texture =
      image_from_camera * camera_from_plane * plane_from_texture;
  cv::Matx33d warp;
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 3; ++col) warp(row, col) = image_from_texture(row, col);
  }
  cv::Mat image;
  cv::warpPerspective(texture_,
                      image,
                      warp,
                      cv::Size(camera.width_px, camera.height_px),
                      cv::INTER_AREA,
                      cv::BORDER_REFLECT);
  return image;
}

// Camera looking down from a position; roll, pitch and yaw of the default mount's body.
inline Rigid3d WorldFromCamera(const Rig& rig,
                               const Eigen::Vector3d& position,
                               const EulerAngles& attitude) {
  return Rigid3d{WorldFromNed() * NedFromBody(attitude), position} * rig.body_from_camera;
}

}  // namespace freelsd
