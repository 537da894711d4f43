// Rigid transforms and autopilot attitudes.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace freelsd {

// Transforms a point from source to target: x_in_target = rotation * x_in_source + translation.
struct Rigid3d {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
};

inline Eigen::Vector3d operator*(const Rigid3d& target_from_source,
                                 const Eigen::Vector3d& x_in_source) {
  return target_from_source.rotation * x_in_source + target_from_source.translation;
}

// c_from_a = c_from_b * b_from_a.
inline Rigid3d operator*(const Rigid3d& c_from_b, const Rigid3d& b_from_a) {
  return {(c_from_b.rotation * b_from_a.rotation).normalized(),
          c_from_b.rotation * b_from_a.translation + c_from_b.translation};
}

inline Rigid3d Inverse(const Rigid3d& b_from_a) {
  const Eigen::Quaterniond a_from_b = b_from_a.rotation.conjugate();
  return {a_from_b, -(a_from_b * b_from_a.translation)};
}

constexpr double kPi = 3.14159265358979323846;
constexpr double DegFromRad(double angle) { return angle * 180.0 / kPi; }
constexpr double RadFromDeg(double angle_deg) { return angle_deg * kPi / 180.0; }
// The same angle in (-pi, pi].
double WrapAngle(double angle);

// Autopilot attitude in radians, Euler order Z-Y-X: yaw clockwise from north, then pitch (nose up
// positive), then roll (right wing down positive).
struct EulerAngles {
  double roll = 0.0;
  double pitch = 0.0;
  double yaw = 0.0;
};
Eigen::Quaterniond NedFromBody(const EulerAngles& attitude);
EulerAngles EulerFromNedFromBody(const Eigen::Quaterniond& ned_from_body);
// East-north-up from north-east-down: swaps x and y, negates z. This rotation is its own inverse.
Eigen::Quaterniond WorldFromNed();
// Heading of a direction in world: radians clockwise from north, in [0, 2 pi).
double HeadingOf(const Eigen::Vector2d& direction_in_world);
// Unit vector east-north of a heading in radians clockwise from north.
Eigen::Vector2d DirectionOf(double heading);
// Angle in radians by which two rotations differ, in [0, pi].
double AngleBetween(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b);

}  // namespace freelsd
