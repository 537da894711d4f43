// Computes where a camera's ray meets level ground, in units of the camera's height.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace freelsd {

// Cross-product matrix: CrossMatrix(a) * b = a x b.
inline Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d cross;
  cross << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return cross;
}

// Horizontal offset (east, north) of the ground point from the camera per metre of height, and its
// derivative with respect to a small rotation vector in world.
struct UnitPlace {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  Eigen::Matrix<double, 2, 3> by_rotation = Eigen::Matrix<double, 2, 3>::Zero();
  bool is_below_horizon = false;
};

inline UnitPlace UnitPlaceOf(const Eigen::Quaterniond& world_from_camera,
                             const Eigen::Vector2d& point_normalized) {
  // Sine of the least angle below the horizon. Flatter rays are not used, because their place on
  // the ground is too uncertain.
  constexpr double kMinDown = 0.2;
  const Eigen::Vector3d ray = world_from_camera * point_normalized.homogeneous();
  const double depth = -ray.z();
  UnitPlace unit;
  if (depth < kMinDown * ray.norm()) return unit;
  unit.place = ray.head<2>() / depth;
  Eigen::Matrix<double, 2, 3> by_ray;
  by_ray << 1.0 / depth, 0.0, ray.x() / (depth * depth), 0.0, 1.0 / depth,
      ray.y() / (depth * depth);
  unit.by_rotation = -(by_ray * CrossMatrix(ray));
  unit.is_below_horizon = true;
  return unit;
}

}  // namespace freelsd
