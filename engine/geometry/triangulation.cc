#include "engine/geometry/triangulation.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

namespace freelsd {
namespace {

constexpr int kNumRefinements = 3;
// Below this the normal matrix of the rays is singular, because they are parallel.
constexpr double kMinConditioning = 1e-9;
constexpr double kMinDepth = 1e-6;

// The normal matrix is a sum of one matrix per ray with the eigenvalues 0, 1 and 1.
bool IsSingular(const Eigen::Matrix3d& normal_matrix, size_t num_rays) {
  // No eigenvalue exceeds the number of rays n, so the smallest is at least determinant / n^2. This
  // bound saves most tracks the decomposition; the factor covers rounding.
  const double n = static_cast<double>(num_rays);
  if (normal_matrix.determinant() > 100.0 * kMinConditioning * n * n * n) return false;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(normal_matrix);
  return eigen.eigenvalues()[0] < kMinConditioning * eigen.eigenvalues()[2];
}

std::optional<Eigen::Vector3d> ClosestPoint(const std::vector<PosedRay>& rays) {
  Eigen::Matrix3d normal_matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right_side = Eigen::Vector3d::Zero();
  for (const PosedRay& ray : rays) {
    const Eigen::Vector3d direction =
        ray.world_from_camera.rotation * ray.point_normalized.homogeneous().normalized();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - direction * direction.transpose();
    normal_matrix += across;
    right_side += across * ray.world_from_camera.translation;
  }
  if (IsSingular(normal_matrix, rays.size())) return std::nullopt;
  return normal_matrix.ldlt().solve(right_side);
}

// One Gauss-Newton step on the reprojection error; false when the point is behind a camera.
bool Refine(const std::vector<PosedRay>& rays, TriangulatedPoint& point) {
  Eigen::Matrix3d normal_matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  double squared_error = 0.0;
  for (const PosedRay& ray : rays) {
    const Eigen::Matrix3d camera_from_world =
        ray.world_from_camera.rotation.conjugate().toRotationMatrix();
    const Eigen::Vector3d x =
        camera_from_world * (point.point_in_world - ray.world_from_camera.translation);
    if (x.z() < kMinDepth) return false;
    const Eigen::Vector2d residual = x.head<2>() / x.z() - ray.point_normalized;
    Eigen::Matrix<double, 2, 3> projection;
    projection << 1.0 / x.z(), 0.0, -x.x() / (x.z() * x.z()), 0.0, 1.0 / x.z(),
        -x.y() / (x.z() * x.z());
    const Eigen::Matrix<double, 2, 3> jacobian = projection * camera_from_world;
    normal_matrix += jacobian.transpose() * jacobian;
    gradient += jacobian.transpose() * residual;
    squared_error += residual.squaredNorm();
  }
  point.rms_error_normalized = std::sqrt(squared_error / static_cast<double>(rays.size()));
  point.point_in_world -= normal_matrix.ldlt().solve(gradient);
  return true;
}

double LargestParallax(const std::vector<PosedRay>& rays, const Eigen::Vector3d& point_in_world) {
  std::vector<Eigen::Vector3d> directions;
  directions.reserve(rays.size());
  double smallest_cosine = 1.0;
  for (const PosedRay& ray : rays) {
    const Eigen::Vector3d direction =
        (point_in_world - ray.world_from_camera.translation).normalized();
    for (const Eigen::Vector3d& other : directions) {
      smallest_cosine = std::min(smallest_cosine, other.dot(direction));
    }
    directions.push_back(direction);
  }
  return std::acos(std::clamp(smallest_cosine, -1.0, 1.0));
}

}  // namespace

std::optional<TriangulatedPoint> Triangulate(const std::vector<PosedRay>& rays) {
  if (rays.size() < 2) return std::nullopt;
  const std::optional<Eigen::Vector3d> closest = ClosestPoint(rays);
  if (!closest) return std::nullopt;
  TriangulatedPoint point;
  point.point_in_world = *closest;
  for (int i = 0; i < kNumRefinements; ++i) {
    if (!Refine(rays, point)) return std::nullopt;
  }
  if (!point.point_in_world.allFinite()) return std::nullopt;
  point.parallax = LargestParallax(rays, point.point_in_world);
  return point;
}

}  // namespace freelsd
