// Multi-view triangulation from posed rays.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "engine/geometry/rigid3.h"

namespace freelsd {

struct PosedRay {
  Rigid3d world_from_camera;
  // Ideal (undistorted) direction (x / z, y / z) in the camera frame.
  Eigen::Vector2d point_normalized = Eigen::Vector2d::Zero();
};

struct TriangulatedPoint {
  Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();
  // Largest angle between two of the rays, radians: the parallax.
  double parallax = 0.0;
  // Root mean square distance between observation and projection, normalised image units.
  double rms_error_normalized = 0.0;
};

// Starts at the point with the least sum of squared distances to the rays, then minimises the
// reprojection error by a few Gauss-Newton steps. Nothing if there are fewer than two rays, if the
// rays are parallel, or if the point is behind a camera.
std::optional<TriangulatedPoint> Triangulate(const std::vector<PosedRay>& rays);

}  // namespace freelsd
