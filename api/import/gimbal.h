// Attitudes of cameras as gimbals and photographs state them.
#pragma once

#include "engine/geometry/geometry.h"

namespace freelsd {

// Gimbal angles as DJI writes them: the axes of a body whose nose is the optical axis, Z-Y-X in
// north-east-down; pitch -90 deg looks straight down, and yaw is then the heading of the image's
// top. Radians.
inline Eigen::Quaterniond NedFromGimbalCamera(const EulerAngles& gimbal) {
  // Camera x (right) is gimbal y, camera y (down) is gimbal z, camera z (ahead) is gimbal x.
  Eigen::Matrix3d gimbal_from_camera;
  gimbal_from_camera << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  return (NedFromBody(gimbal) * Eigen::Quaterniond(gimbal_from_camera)).normalized();
}

// A camera that looks straight down from a body in this attitude, image top towards the nose.
inline Eigen::Quaterniond NedFromDownCamera(const EulerAngles& body) {
  const Eigen::Quaterniond body_from_camera(Eigen::AngleAxisd(kPi / 2, Eigen::Vector3d::UnitZ()));
  return (NedFromBody(body) * body_from_camera).normalized();
}

}  // namespace freelsd
