// Camera attitudes from the angles in gimbal data and photographs.
#pragma once

#include "engine/geometry/geometry.h"

namespace freelsd {

// `gimbal` has DJI's convention: yaw, pitch and roll of a body whose nose is the optical axis, from
// north-east-down, Z-Y-X, radians. At pitch -90 deg the camera looks straight down, and yaw is the
// heading of the image's top.
inline Eigen::Quaterniond NedFromGimbalCamera(const EulerAngles& gimbal) {
  // Camera x (right) is gimbal y, camera y (down) is gimbal z, camera z (ahead) is gimbal x.
  Eigen::Matrix3d gimbal_from_camera;
  gimbal_from_camera << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  return (NedFromBody(gimbal) * Eigen::Quaterniond(gimbal_from_camera)).normalized();
}

// A camera fixed to a body in this attitude. It looks down, with the image's top to the nose.
inline Eigen::Quaterniond NedFromDownCamera(const EulerAngles& body) {
  const Eigen::Quaterniond body_from_camera(Eigen::AngleAxisd(kPi / 2, Eigen::Vector3d::UnitZ()));
  return (NedFromBody(body) * body_from_camera).normalized();
}

}  // namespace freelsd
