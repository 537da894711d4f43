#include "engine/geometry/camera.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "engine/check/check.h"

namespace freelsd {
namespace {

constexpr int kNumNewtonSteps = 20;
constexpr double kNewtonTolerance = 1e-12;
constexpr int kNumRowSteps = 20;
constexpr double kRowTolerancePx = 1e-9;
constexpr double kDerivativeStep = 1e-7;
// Samples along the radius at which the lens polynomial must still rise.
constexpr int kNumFoldSamples = 16;
constexpr double kBorderTolerancePx = 0.5;
constexpr double kMinFocalRatio = 0.05;
constexpr double kMaxFocalRatio = 100.0;
// Largest angle from the optical axis of a perspective camera (cos 85 deg).
constexpr double kMinCosOffAxis = 0.087;

double CoefficientAt(const Camera& camera, size_t index) {
  return index < camera.coefficients.size() ? camera.coefficients[index] : 0.0;
}

// Brown-Conrady, as OpenCV: k1, k2, p1, p2, k3.
Eigen::Vector2d DistortRadTan(const Camera& camera, const Eigen::Vector2d& p) {
  const double k1 = CoefficientAt(camera, 0), k2 = CoefficientAt(camera, 1);
  const double p1 = CoefficientAt(camera, 2), p2 = CoefficientAt(camera, 3);
  const double k3 = CoefficientAt(camera, 4);
  const double r2 = p.squaredNorm();
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {p.x() * radial + 2.0 * p1 * p.x() * p.y() + p2 * (r2 + 2.0 * p.x() * p.x()),
          p.y() * radial + p1 * (r2 + 2.0 * p.y() * p.y()) + 2.0 * p2 * p.x() * p.y()};
}

// Kannala-Brandt, as OpenCV fisheye: theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8).
Eigen::Vector2d DistortEquidistant(const Camera& camera, const Eigen::Vector2d& p) {
  const double r = p.norm();
  if (r < 1e-12) return p;
  const double theta = std::atan(r);
  const double t2 = theta * theta;
  const double polynomial =
      1.0 + t2 * (CoefficientAt(camera, 0) +
                  t2 * (CoefficientAt(camera, 1) +
                        t2 * (CoefficientAt(camera, 2) + t2 * CoefficientAt(camera, 3))));
  return p * (theta * polynomial / r);
}

Eigen::Vector2d Distort(const Camera& camera, const Eigen::Vector2d& p) {
  switch (camera.distortion) {
    case DistortionModel::kRadTan:
      return DistortRadTan(camera, p);
    case DistortionModel::kEquidistant:
      return DistortEquidistant(camera, p);
    case DistortionModel::kNone:
      break;
  }
  return p;
}

Eigen::Matrix2d DistortionJacobian(const Camera& camera, const Eigen::Vector2d& p) {
  Eigen::Matrix2d jacobian;
  for (int axis = 0; axis < 2; ++axis) {
    Eigen::Vector2d step = Eigen::Vector2d::Zero();
    step[axis] = kDerivativeStep;
    jacobian.col(axis) =
        (Distort(camera, p + step) - Distort(camera, p - step)) / (2.0 * kDerivativeStep);
  }
  return jacobian;
}

// Derivative of the distorted radius by the undistorted one (by the angle for kEquidistant), as a
// polynomial of the squared radius (angle).
struct RadialSlope {
  double k1, k2, k3, k4;

  double At(double u) const {
    return 1.0 + u * (3.0 * k1 + u * (5.0 * k2 + u * (7.0 * k3 + u * 9.0 * k4)));
  }
  bool AlwaysRises() const { return std::min({k1, k2, k3, k4}) >= 0.0; }
};

RadialSlope RadialSlopeOf(const Camera& camera) {
  const bool is_equidistant = camera.distortion == DistortionModel::kEquidistant;
  return {CoefficientAt(camera, 0),
          CoefficientAt(camera, 1),
          CoefficientAt(camera, is_equidistant ? 2 : 4),
          is_equidistant ? CoefficientAt(camera, 3) : 0.0};
}

// A lens polynomial may fold back outside its fitted field, and further out may even mirror points
// into the image. Points beyond the first fold are not seen.
bool IsBeyondFold(const Camera& camera, const Eigen::Vector2d& p) {
  if (camera.distortion == DistortionModel::kNone) return false;
  const bool is_equidistant = camera.distortion == DistortionModel::kEquidistant;
  const double radius = is_equidistant ? std::atan(p.norm()) : p.norm();
  const RadialSlope slope = RadialSlopeOf(camera);
  for (int i = 1; i <= kNumFoldSamples && !slope.AlwaysRises(); ++i) {
    if (slope.At(radius * radius * i / kNumFoldSamples) <= 0.0) return true;
  }
  return DistortionJacobian(camera, p).determinant() <= 0.0;
}

// From the camera at the time of a row to the camera at the image's middle.
Eigen::Quaterniond MiddleFromRow(const Camera& camera, double row) {
  const Eigen::Vector3d half = 0.5 * camera.readout.TurnAt((row - camera.cy_px) / camera.height_px);
  return Eigen::Quaterniond(1.0, half.x(), half.y(), half.z()).normalized();
}

// Pixel of a point when all rows are exposed at once.
std::optional<Eigen::Vector2d> ProjectAtOnce(const Camera& camera, const Eigen::Vector3d& point) {
  if (point.z() <= kMinCosOffAxis * point.norm()) return std::nullopt;
  const Eigen::Vector2d normalized = point.head<2>() / point.z();
  if (IsBeyondFold(camera, normalized)) return std::nullopt;
  const Eigen::Vector2d distorted = Distort(camera, normalized);
  return Eigen::Vector2d(camera.fx_px * distorted.x() + camera.cx_px,
                         camera.fy_px * distorted.y() + camera.cy_px);
}

// The lens must be valid out to the middles of the borders, because rays beyond the fold are
// undefined. Some calibrations fold within the corners; no point is projected there.
void CheckBorder(const Camera& camera, const FieldCheck& check) {
  if (camera.distortion == DistortionModel::kNone) return;
  const double right = camera.width_px - 1, bottom = camera.height_px - 1;
  const Eigen::Vector2d middle(0.5 * right, 0.5 * bottom);
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(0.0, middle.y()),
                                       Eigen::Vector2d(right, middle.y()),
                                       Eigen::Vector2d(middle.x(), 0.0),
                                       Eigen::Vector2d(middle.x(), bottom)}) {
    const Eigen::Vector2d ray = camera.NormalizedFromImage(pixel);
    const std::optional<Eigen::Vector2d> back =
        ray.allFinite() ? ProjectAtOnce(camera, ray.homogeneous()) : std::nullopt;
    check.Require(back && (*back - pixel).norm() < kBorderTolerancePx,
                  "distortion.coefficients",
                  CoefficientAt(camera, 0),
                  "the lens polynomial folds back, or sees nothing, within the image");
  }
}

}  // namespace

Readout Readout::Turning(const Eigen::Vector3d& turn, const Eigen::Vector3d& bend) {
  Readout readout;
  readout.turns.col(0) = turn;
  readout.turns.col(1) = bend;
  return readout;
}

Eigen::Vector3d Readout::TurnAt(double share) const {
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  for (int k = kNumTurns - 1; k >= 0; --k) turn = share * (turn + turns.col(k));
  return turn;
}

std::optional<Eigen::Vector2d> Camera::ImageFromCamera(
    const Eigen::Vector3d& point_in_camera) const {
  std::optional<Eigen::Vector2d> pixel = ProjectAtOnce(*this, point_in_camera);
  if (readout.IsGlobal()) return pixel;
  // The row gives the turn, and the turn changes the row. The error of each round shrinks by the
  // ratio of the turn to the field of view.
  for (int i = 0; i < kNumRowSteps && pixel; ++i) {
    const double row = pixel->y();
    pixel = ProjectAtOnce(*this, MiddleFromRow(*this, row).conjugate() * point_in_camera);
    if (pixel && std::abs(pixel->y() - row) < kRowTolerancePx) break;
  }
  return pixel;
}

Eigen::Vector2d Camera::NormalizedFromImage(const Eigen::Vector2d& point_in_image) const {
  const Eigen::Vector2d target((point_in_image.x() - cx_px) / fx_px,
                               (point_in_image.y() - cy_px) / fy_px);
  Eigen::Vector2d guess = target;
  for (int i = 0; distortion != DistortionModel::kNone && i < kNumNewtonSteps; ++i) {
    const Eigen::Vector2d error = Distort(*this, guess) - target;
    if (error.norm() < kNewtonTolerance) break;
    guess -= DistortionJacobian(*this, guess).inverse() * error;
  }
  if (readout.IsGlobal()) return guess;
  return (MiddleFromRow(*this, point_in_image.y()) * guess.homogeneous()).hnormalized();
}

Eigen::Vector3d Camera::RayFromImage(const Eigen::Vector2d& point_in_image) const {
  return NormalizedFromImage(point_in_image).homogeneous().normalized();
}

bool Camera::IsInside(const Eigen::Vector2d& point_in_image, double margin_px) const {
  return point_in_image.x() >= margin_px && point_in_image.y() >= margin_px &&
         point_in_image.x() <= width_px - 1 - margin_px &&
         point_in_image.y() <= height_px - 1 - margin_px;
}

Camera Camera::Scaled(double factor) const {
  Camera scaled = *this;
  scaled.width_px = static_cast<int>(std::lround(width_px * factor));
  scaled.height_px = static_cast<int>(std::lround(height_px * factor));
  const double factor_x = static_cast<double>(scaled.width_px) / width_px;
  const double factor_y = static_cast<double>(scaled.height_px) / height_px;
  scaled.fx_px = fx_px * factor_x;
  scaled.fy_px = fy_px * factor_y;
  scaled.cx_px = (cx_px + 0.5) * factor_x - 0.5;
  scaled.cy_px = (cy_px + 0.5) * factor_y - 0.5;
  return scaled;
}

Camera Camera::With(const Readout& readout_of_image) const {
  Camera camera = *this;
  camera.readout = readout_of_image;
  return camera;
}

void Camera::Check() const {
  const FieldCheck check("camera");
  check.Require(width_px > 0, "width_px", width_px, "must be positive");
  check.Require(height_px > 0, "height_px", height_px, "must be positive");
  check.Require(std::isfinite(fx_px) && fx_px > 0.0, "fx_px", fx_px, "must be positive");
  check.Require(std::isfinite(fy_px) && fy_px > 0.0, "fy_px", fy_px, "must be positive");
  // Wider than any lens to narrower than a telescope; pixels are nearly square.
  const double size_px = std::max(width_px, height_px);
  check.Require(fx_px >= kMinFocalRatio * size_px && fx_px <= kMaxFocalRatio * size_px,
                "fx_px",
                fx_px,
                "must be between 0.05 and 100 times the larger side of the image");
  check.Require(fy_px >= 0.5 * fx_px && fy_px <= 2.0 * fx_px,
                "fy_px",
                fy_px,
                "must be between half and twice fx_px");
  check.Require(
      cx_px >= 0.0 && cx_px <= width_px - 1.0, "cx_px", cx_px, "must be within the image");
  check.Require(
      cy_px >= 0.0 && cy_px <= height_px - 1.0, "cy_px", cy_px, "must be within the image");
  // Slower than any sensor: a larger value has a wrong unit.
  constexpr double kMaxReadoutS = 1.0;
  check.Require(
      readout_s >= 0.0 && readout_s <= kMaxReadoutS, "readout_s", readout_s, "must be in [0, 1]");
  const size_t count = coefficients.size();
  const double shown = static_cast<double>(count);
  if (distortion == DistortionModel::kNone) {
    check.Require(count == 0, "distortion.coefficients", shown, "model none takes no coefficients");
  } else if (distortion == DistortionModel::kRadTan) {
    check.Require(
        count == 4 || count == 5, "distortion.coefficients", shown, "radtan takes 4 or 5");
  } else {
    check.Require(count == 4, "distortion.coefficients", shown, "equidistant takes 4");
  }
  for (const double coefficient : coefficients) {
    check.Require(
        std::isfinite(coefficient), "distortion.coefficients", coefficient, "must be finite");
  }
  CheckBorder(*this, check);
}

}  // namespace freelsd
