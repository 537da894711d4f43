#include "engine/geometry/camera.h"

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace freelsd {
namespace {

constexpr int kNumNewtonSteps = 20;
constexpr double kNewtonTolerance = 1e-12;
constexpr double kDerivativeStep = 1e-7;
// Beyond this angle from the optical axis a perspective camera sees nothing useful (cos 85 deg).
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

// Where a pixel of an instantaneous image comes to lie when rows are read one after the other. The
// share is that of the displaced row, so it is solved for.
Eigen::Vector2d Displaced(const Camera& camera, const Eigen::Vector2d& pixel) {
  const Readout& readout = camera.readout;
  if (readout.IsGlobal()) return pixel;
  const Eigen::Vector2d p(pixel.x() - camera.cx_px, pixel.y() - camera.cy_px);
  const double down = (readout.down_px + readout.turn * p.x()) / camera.height_px;
  const double y = p.y() / (1.0 - down);
  const double share = y / camera.height_px;
  return {pixel.x() + share * (readout.right_px - readout.turn * p.y()), camera.cy_px + y};
}

// The inverse.
Eigen::Vector2d Instantaneous(const Camera& camera, const Eigen::Vector2d& pixel) {
  const Readout& readout = camera.readout;
  if (readout.IsGlobal()) return pixel;
  const double share = (pixel.y() - camera.cy_px) / camera.height_px;
  const double turn = share * readout.turn;
  const Eigen::Vector2d p(pixel.x() - camera.cx_px - share * readout.right_px,
                          pixel.y() - camera.cy_px - share * readout.down_px);
  const double scale = 1.0 + turn * turn;
  return {camera.cx_px + (p.x() + turn * p.y()) / scale,
          camera.cy_px + (p.y() - turn * p.x()) / scale};
}

void Require(bool holds, const char* field, double value, const char* constraint) {
  if (holds) return;
  std::ostringstream message;
  message << "camera." << field << " = " << value << ": " << constraint;
  throw std::invalid_argument(message.str());
}

}  // namespace

std::optional<Eigen::Vector2d> Camera::ImageFromCamera(
    const Eigen::Vector3d& point_in_camera) const {
  if (point_in_camera.z() <= kMinCosOffAxis * point_in_camera.norm()) return std::nullopt;
  const Eigen::Vector2d normalized = point_in_camera.head<2>() / point_in_camera.z();
  const Eigen::Vector2d distorted = Distort(*this, normalized);
  // A lens polynomial may fold back outside its fitted field: such a point is not seen.
  if (distortion != DistortionModel::kNone &&
      DistortionJacobian(*this, normalized).determinant() <= 0.0) {
    return std::nullopt;
  }
  return Displaced(*this, {fx_px * distorted.x() + cx_px, fy_px * distorted.y() + cy_px});
}

Eigen::Vector2d Camera::NormalizedFromImage(const Eigen::Vector2d& point_in_image) const {
  const Eigen::Vector2d instantaneous = Instantaneous(*this, point_in_image);
  const Eigen::Vector2d target((instantaneous.x() - cx_px) / fx_px,
                               (instantaneous.y() - cy_px) / fy_px);
  if (distortion == DistortionModel::kNone) return target;
  Eigen::Vector2d guess = target;
  for (int i = 0; i < kNumNewtonSteps; ++i) {
    const Eigen::Vector2d error = Distort(*this, guess) - target;
    if (error.norm() < kNewtonTolerance) break;
    guess -= DistortionJacobian(*this, guess).inverse() * error;
  }
  return guess;
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
  scaled.readout.right_px *= factor_x;
  scaled.readout.down_px *= factor_y;
  return scaled;
}

Camera Camera::With(const Readout& readout_of_image) const {
  Camera camera = *this;
  camera.readout = readout_of_image;
  return camera;
}

void Camera::Check() const {
  Require(width_px > 0, "width_px", width_px, "must be positive");
  Require(height_px > 0, "height_px", height_px, "must be positive");
  Require(std::isfinite(fx_px) && fx_px > 0.0, "fx_px", fx_px, "must be positive");
  Require(std::isfinite(fy_px) && fy_px > 0.0, "fy_px", fy_px, "must be positive");
  Require(std::isfinite(cx_px), "cx_px", cx_px, "must be finite");
  Require(std::isfinite(cy_px), "cy_px", cy_px, "must be finite");
  // Slower than any sensor: a unit is wrong.
  constexpr double kMaxReadoutS = 1.0;
  Require(readout_s >= 0.0 && readout_s <= kMaxReadoutS,
          "readout_s",
          readout_s,
          "must be in [0, 1]");
  const size_t count = coefficients.size();
  const double shown = static_cast<double>(count);
  if (distortion == DistortionModel::kNone) {
    Require(count == 0, "distortion.coefficients", shown, "model none takes no coefficients");
  } else if (distortion == DistortionModel::kRadTan) {
    Require(count == 4 || count == 5, "distortion.coefficients", shown, "radtan takes 4 or 5");
  } else {
    Require(count == 4, "distortion.coefficients", shown, "equidistant takes 4");
  }
  for (const double coefficient : coefficients) {
    Require(std::isfinite(coefficient), "distortion.coefficients", coefficient, "must be finite");
  }
}

}  // namespace freelsd
