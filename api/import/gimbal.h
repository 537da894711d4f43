// Camera attitudes from the angles in gimbal data and photographs.
#pragma once

#include "engine/geometry/geometry.h"

namespace freelsd {

// `gimbal` has DJI's convention: Euler angles Z-Y-X in radians, from north-east-down to a body
// whose nose points along the optical axis. At pitch -90 deg the camera looks straight down, and
// yaw is the heading of the image's top.
inline Eigen::Quaterniond NedFromGimbalCamera(const EulerAngles& gimbal) {
  // Camera x (right) is gimbal y, camera y (down) is gimbal z, camera z (ahead) is gimbal x.
  Eigen::Matrix3d gimbal_from_camera;
  gimbal_from_camera << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  return (NedFromBody(gimbal) * Eigen::Quaterniond(gimbal_from_camera)).normalized();
}

// Attitude of a camera that is fixed to a body; `body` is the body's attitude. The camera looks
// down, and the top of the image is at the nose.
inline Eigen::Quaterniond NedFromDownCamera(const EulerAngles& body) {
  const Eigen::Quaterniond body_from_camera(Eigen::AngleAxisd(kPi / 2, Eigen::Vector3d::UnitZ()));
  return (NedFromBody(body) * body_from_camera).normalized();
}

}  // namespace freelsd
