#include "api/import/gimbal.h"

#include <doctest/doctest.h>

namespace freelsd {
namespace {

constexpr double kMaxRotationErrorRad = 1e-9;

EulerAngles Radians(double roll_deg, double pitch_deg, double yaw_deg) {
  return {RadFromDeg(roll_deg), RadFromDeg(pitch_deg), RadFromDeg(yaw_deg)};
}

TEST_CASE("gimbal: straight down, and yaw is the heading of the image's top") {
  const Eigen::Quaterniond ned_from_camera = NedFromGimbalCamera(Radians(0, -90, 90));
  const Eigen::Vector3d axis = ned_from_camera * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d top = ned_from_camera * -Eigen::Vector3d::UnitY();
  CHECK((axis - Eigen::Vector3d(0, 0, 1)).norm() < kMaxRotationErrorRad);
  CHECK((top - Eigen::Vector3d(0, 1, 0)).norm() < kMaxRotationErrorRad);
}

TEST_CASE("gimbal: half way down and north, the axis falls as much as it goes on") {
  const Eigen::Quaterniond ned_from_camera = NedFromGimbalCamera(Radians(0, -45, 0));
  const double half = std::sqrt(0.5);
  const Eigen::Vector3d axis = ned_from_camera * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d right = ned_from_camera * Eigen::Vector3d::UnitX();
  CHECK((axis - Eigen::Vector3d(half, 0, half)).norm() < kMaxRotationErrorRad);
  CHECK((right - Eigen::Vector3d(0, 1, 0)).norm() < kMaxRotationErrorRad);
}

TEST_CASE("gimbal: a camera below a level body is the gimbal's straight down") {
  CHECK(AngleBetween(NedFromDownCamera(Radians(0, 0, 33)),
                     NedFromGimbalCamera(Radians(0, -90, 33))) < kMaxRotationErrorRad);
}

}  // namespace
}  // namespace freelsd
