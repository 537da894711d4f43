#include "tests/evaluation/scores/elevation_error.h"

#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include <Eigen/Dense>

#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

constexpr double kClipSds = 3.0;
constexpr double kWindowM = 20.0;
// Fewer errors in a window say nothing about their deviation.
constexpr int64_t kMinInWindow = 30;

// Over the errors within `limit` of a plane.
ErrorPlane FitWithin(const std::vector<HeightError>& errors,
                     const ErrorPlane& plane,
                     double limit) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const HeightError& each : errors) {
    if (std::abs(each.error - plane.At(each.place)) > limit) continue;
    const Eigen::Vector3d terms(1.0, each.place.x(), each.place.y());
    normal += terms * terms.transpose();
    right += each.error * terms;
  }
  const Eigen::FullPivLU<Eigen::Matrix3d> solver(normal);
  if (!solver.isInvertible()) return plane;
  const Eigen::Vector3d solution = solver.solve(right);
  return {solution.x(), solution.tail<2>()};
}

}  // namespace

double ErrorPlane::TiltDeg() const { return DegFromRad(std::atan(gradient.norm())); }

ErrorPlane FitErrorPlane(const std::vector<HeightError>& errors) {
  ErrorPlane all = FitWithin(errors, {}, std::numeric_limits<double>::infinity());
  Sums residual;
  for (const HeightError& each : errors) residual.Add(each.error - all.At(each.place));
  if (residual.count == 0) return all;
  return FitWithin(errors, all, kClipSds * residual.Rms());
}

DetiltedErrors Detilt(const std::vector<HeightError>& errors) {
  DetiltedErrors detilted;
  detilted.plane = FitErrorPlane(errors);
  std::map<std::pair<int, int>, Sums> windows;
  for (const HeightError& each : errors) {
    const double residual = each.error - detilted.plane.At(each.place);
    detilted.residual.Add(residual);
    const Eigen::Vector2d window = (each.place / kWindowM).array().floor();
    windows[{static_cast<int>(window.x()), static_cast<int>(window.y())}].Add(residual);
  }
  for (const auto& [window, sums] : windows) {
    if (sums.count >= kMinInWindow) detilted.local_noise.Add(sums.Sd());
  }
  return detilted;
}

}  // namespace freelsd
