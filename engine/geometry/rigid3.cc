#include "engine/geometry/rigid3.h"

#include <algorithm>
#include <cmath>

namespace freelsd {

double WrapAngle(double angle) {
  const double wrapped = std::remainder(angle, 2.0 * kPi);
  return wrapped <= -kPi ? wrapped + 2.0 * kPi : wrapped;
}

Eigen::Quaterniond NedFromBody(const EulerAngles& attitude) {
  return Eigen::AngleAxisd(attitude.yaw, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(attitude.pitch, Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(attitude.roll, Eigen::Vector3d::UnitX());
}

EulerAngles EulerFromNedFromBody(const Eigen::Quaterniond& ned_from_body) {
  const Eigen::Matrix3d rotation = ned_from_body.toRotationMatrix();
  EulerAngles attitude;
  attitude.pitch = std::asin(std::clamp(-rotation(2, 0), -1.0, 1.0));
  attitude.roll = std::atan2(rotation(2, 1), rotation(2, 2));
  attitude.yaw = std::atan2(rotation(1, 0), rotation(0, 0));
  return attitude;
}

Eigen::Quaterniond WorldFromNed() {
  Eigen::Matrix3d world_from_ned;
  world_from_ned << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  return Eigen::Quaterniond(world_from_ned);
}

double HeadingOf(const Eigen::Vector2d& direction_in_world) {
  const double heading = std::atan2(direction_in_world.x(), direction_in_world.y());
  return heading < 0.0 ? heading + 2.0 * kPi : heading;
}

Eigen::Vector2d DirectionOf(double heading) { return {std::sin(heading), std::cos(heading)}; }

double AngleBetween(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return a.angularDistance(b);
}

}  // namespace freelsd
