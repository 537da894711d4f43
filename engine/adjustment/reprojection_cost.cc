#include "engine/adjustment/reprojection_cost.h"

#include <cmath>

namespace freelsd {
namespace {

enum Block { kPose, kLandmark, kLens, kReadout };

// CrossWith(a) * b = a x b.
Eigen::Matrix3d CrossWith(const Eigen::Vector3d& a) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return matrix;
}

// Powers of the share, from the first, and their derivatives.
struct Powers {
  Eigen::Matrix<double, Readout::kNumTurns, 1> value, slope;
};

Powers PowersOf(double share) {
  Powers powers;
  double power = 1.0;
  for (int k = 0; k < Readout::kNumTurns; ++k) {
    powers.slope[k] = (k + 1) * power;
    power *= share;
    powers.value[k] = power;
  }
  return powers;
}

// The rotation of the residual, times a scale.
Eigen::Matrix3d RowFromMiddle(const Eigen::Vector3d& turned) {
  return (1.0 - 0.25 * turned.squaredNorm()) * Eigen::Matrix3d::Identity() - CrossWith(turned) +
         0.5 * turned * turned.transpose();
}

// Derivative of RowFromMiddle(turned) * seen by turned.
Eigen::Matrix3d TurnedSlope(const Eigen::Vector3d& turned, const Eigen::Vector3d& seen) {
  return CrossWith(seen) + 0.5 * (turned * seen.transpose() - seen * turned.transpose() +
                                  turned.dot(seen) * Eigen::Matrix3d::Identity());
}

// Copies the Jacobian if the solver requests it.
template <int kCols>
void Write(const Eigen::Matrix<double, 2, kCols>& slope, double* jacobian) {
  if (jacobian == nullptr) return;
  Eigen::Map<Eigen::Matrix<double, 2, kCols, Eigen::RowMajor>> to(jacobian);
  to = slope;
}

// Brown's model: radial k1, k2, k3 and tangential p1, p2.
struct Brown {
  double k1 = 0.0, k2 = 0.0, k3 = 0.0, p1 = 0.0, p2 = 0.0;

  Eigen::Vector2d At(const Eigen::Vector2d& p) const {
    const double r2 = p.squaredNorm(), xy = 2.0 * p.x() * p.y();
    const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
    return {p.x() * radial + p1 * xy + p2 * (r2 + 2.0 * p.x() * p.x()),
            p.y() * radial + p1 * (r2 + 2.0 * p.y() * p.y()) + p2 * xy};
  }

  Eigen::Matrix2d SlopeAt(const Eigen::Vector2d& p) const {
    const double r2 = p.squaredNorm();
    const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
    const double rise = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3));
    const double across = p.x() * p.y() * rise + 2.0 * (p1 * p.x() + p2 * p.y());
    Eigen::Matrix2d slope;
    slope << radial + p.x() * p.x() * rise + 2.0 * p1 * p.y() + 6.0 * p2 * p.x(), across, across,
        radial + p.y() * p.y() * rise + 6.0 * p1 * p.y() + 2.0 * p2 * p.x();
    return slope;
  }
};

// A distorted point, and its derivative by the ideal point.
struct Distortion {
  Eigen::Vector2d point;
  Eigen::Matrix2d slope;
};

double CoefficientAt(const Camera& camera, size_t i) {
  return i < camera.coefficients.size() ? camera.coefficients[i] : 0.0;
}

// Kannala and Brandt's model.
Distortion Equidistant(const Camera& camera, const Eigen::Vector2d& p) {
  const double r2 = p.squaredNorm();
  if (r2 <= 1e-16) return {p, Eigen::Matrix2d::Identity()};
  const double k1 = CoefficientAt(camera, 0), k2 = CoefficientAt(camera, 1);
  const double k3 = CoefficientAt(camera, 2), k4 = CoefficientAt(camera, 3);
  const double r = std::sqrt(r2), theta = std::atan(r), t2 = theta * theta;
  const double scale = theta / r * (1.0 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4))));
  const double rise = 1.0 + t2 * (3.0 * k1 + t2 * (5.0 * k2 + t2 * (7.0 * k3 + t2 * 9.0 * k4)));
  const Eigen::Matrix2d outward = p * p.transpose() / r2;
  return {p * scale, scale * Eigen::Matrix2d::Identity() + (rise / (1.0 + r2) - scale) * outward};
}

// Applies the given lens plus the refined change of its coefficients.
Distortion Distorted(const Camera& camera, const Eigen::Vector2d& p, const double* lens) {
  Brown brown{lens[kRadial1], lens[kRadial2], 0.0, lens[kTangential1], lens[kTangential2]};
  if (camera.distortion == DistortionModel::kEquidistant) {
    Distortion given = Equidistant(camera, p);
    given.point += brown.At(p) - p;
    given.slope += brown.SlopeAt(p) - Eigen::Matrix2d::Identity();
    return given;
  }
  if (camera.distortion == DistortionModel::kRadTan) {
    brown.k1 += CoefficientAt(camera, 0);
    brown.k2 += CoefficientAt(camera, 1);
    brown.p1 += CoefficientAt(camera, 2);
    brown.p2 += CoefficientAt(camera, 3);
    brown.k3 += CoefficientAt(camera, 4);
  }
  return {brown.At(p), brown.SlopeAt(p)};
}

// Derivative of R(q)^T v by the entries x, y, z, w of the quaternion.
Eigen::Matrix<double, 3, 4> TurnedBackSlope(const Eigen::Quaterniond& q, const Eigen::Vector3d& v) {
  const Eigen::Vector3d u = -q.vec();
  Eigen::Matrix<double, 3, 4> slope;
  slope.leftCols<3>() = 2.0 * (q.w() * CrossWith(v) - u.dot(v) * Eigen::Matrix3d::Identity() -
                               u * v.transpose() + 2.0 * v * u.transpose());
  slope.col(3) = 2.0 * u.cross(v);
  return slope;
}

// Derivative of the pixel by the lens, at an ideal point and its distorted point.
Eigen::Matrix<double, 2, kNumLensParameters> StillLensSlope(const Camera& camera,
                                                            const double* lens,
                                                            const Eigen::Vector2d& p,
                                                            const Eigen::Vector2d& distorted) {
  const Eigen::Vector2d given(camera.fx_px, camera.fy_px);
  const Eigen::Vector2d focal = given * lens[kFocalFactor];
  const double r2 = p.squaredNorm(), xy = 2.0 * p.x() * p.y();
  Eigen::Matrix<double, 2, kNumLensParameters> slope;
  slope.col(kFocalFactor) = given.cwiseProduct(distorted);
  slope.col(kRadial1) = focal.cwiseProduct(p) * r2;
  slope.col(kRadial2) = focal.cwiseProduct(p) * (r2 * r2);
  slope.col(kTangential1) = focal.cwiseProduct(Eigen::Vector2d(xy, r2 + 2.0 * p.y() * p.y()));
  slope.col(kTangential2) = focal.cwiseProduct(Eigen::Vector2d(r2 + 2.0 * p.x() * p.x(), xy));
  // In units of the focal length along each axis.
  slope.col(kPrincipalX) << camera.fx_px, 0.0;
  slope.col(kPrincipalY) << 0.0, camera.fy_px;
  return slope;
}

}  // namespace

bool ReprojectionCost::Evaluate(double const* const* parameters,
                                double* residuals,
                                double** jacobians) const {
  if (!residual_(parameters[kPose],
                 parameters[kLandmark],
                 parameters[kLens],
                 parameters[kReadout],
                 residuals)) {
    return false;
  }
  if (jacobians == nullptr) return true;
  const Camera& camera = *residual_.camera;
  const double* lens = parameters[kLens];
  const Eigen::Quaterniond world_from_camera =
      Eigen::Map<const Eigen::Quaterniond>(parameters[kPose]);
  const Eigen::Map<const Eigen::Vector3d> position(parameters[kPose] + 4);
  const Eigen::Map<const Eigen::Vector3d> landmark(parameters[kLandmark]);
  const Eigen::Map<const Eigen::Matrix<double, 3, Readout::kNumTurns>> turns(parameters[kReadout]);
  const double cy = camera.cy_px + camera.fy_px * lens[kPrincipalY];
  const double share = (residual_.point_in_image.y() - cy) / camera.height_px;
  const Eigen::Vector3d in_world = landmark - position;
  const Eigen::Vector3d still = world_from_camera.conjugate() * in_world;
  const Powers powers = PowersOf(share);
  const Eigen::Vector3d turned = turns * powers.value;
  const Eigen::Matrix3d row_from_middle = RowFromMiddle(turned);
  const Eigen::Vector3d x = row_from_middle * still;
  const Eigen::Vector2d p = x.head<2>() / x.z();
  const Distortion distorted = Distorted(camera, p, lens);
  const Eigen::Vector2d focal(camera.fx_px * lens[kFocalFactor], camera.fy_px * lens[kFocalFactor]);
  Eigen::Matrix<double, 2, 3> by_x;
  by_x << 1.0 / x.z(), 0.0, -p.x() / x.z(), 0.0, 1.0 / x.z(), -p.y() / x.z();
  by_x = (focal.asDiagonal() * distorted.slope * by_x).eval();
  const Eigen::Matrix<double, 2, 3> by_still = by_x * row_from_middle;
  const Eigen::Matrix<double, 2, 3> by_turned = by_x * TurnedSlope(turned, still);
  const Eigen::Matrix<double, 2, 3> by_world =
      by_still * world_from_camera.conjugate().toRotationMatrix();
  Eigen::Matrix<double, 2, kNumPoseParameters> by_pose;
  by_pose << by_still * TurnedBackSlope(world_from_camera, in_world), -by_world;
  Write<kNumPoseParameters>(by_pose, jacobians[kPose]);
  Write<3>(by_world, jacobians[kLandmark]);
  if (jacobians[kReadout] != nullptr) {
    Eigen::Matrix<double, 2, kNumReadoutParameters> by_readout;
    for (int k = 0; k < Readout::kNumTurns; ++k) {
      by_readout.middleCols<3>(3 * k) = powers.value[k] * by_turned;
    }
    Write<kNumReadoutParameters>(by_readout, jacobians[kReadout]);
  }
  if (jacobians[kLens] == nullptr) return true;
  Eigen::Matrix<double, 2, kNumLensParameters> by_lens =
      StillLensSlope(camera, lens, p, distorted.point);
  // The middle row moves, and with it the turn of the camera.
  by_lens.col(kPrincipalY) -=
      by_turned * (turns * powers.slope) * (camera.fy_px / camera.height_px);
  Write<kNumLensParameters>(by_lens, jacobians[kLens]);
  return true;
}

}  // namespace freelsd
