// Residuals of the bundle adjustment, in a form that can be differentiated automatically.
//
// Parameter blocks:
//   pose      7  rotation world_from_camera as x, y, z, w (Eigen), then camera position in world
//   landmark  3  point in world
//   lens      7  see LensParameter
//   readout  15  turns of the view, one power after the other (see Readout)
// Rotation and position share one block, because computing time grows with the square of the number
// of blocks.
#pragma once

#include <array>
#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/geometry/geometry.h"

namespace freelsd {

// Refined parameters of the lens. The focal parameter is a factor. The other parameters are added
// to the given values. Those of the principal point are shares of the focal length.
enum LensParameter {
  kFocalFactor,
  kRadial1,
  kRadial2,
  kTangential1,
  kTangential2,
  kPrincipalX,
  kPrincipalY,
  kNumLensParameters
};

constexpr int kNumPoseParameters = 7;
constexpr int kNumReadoutParameters = 3 * Readout::kNumTurns;

struct ReprojectionResidual {
  ReprojectionResidual(const Camera* calibrated_camera, const Eigen::Vector2d& sighting)
      : camera(calibrated_camera), point_in_image(sighting) {}

  // Projection minus sighting, px.
  template <typename T>
  bool operator()(const T* const pose,
                  const T* const landmark,
                  const T* const lens,
                  const T* const readout,
                  T* residual) const {
    const Eigen::Map<const Eigen::Quaternion<T>> world_from_camera(pose);
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> camera_in_world(pose + 4), point(landmark);
    const T cx = T(camera->cx_px) + camera->fx_px * lens[kPrincipalX];
    const T cy = T(camera->cy_px) + camera->fy_px * lens[kPrincipalY];
    // While the rows are read, the camera turns. The row of the sighting determines how far.
    const T share = (T(point_in_image.y()) - cy) / T(camera->height_px);
    const Eigen::Map<const Eigen::Matrix<T, 3, Readout::kNumTurns>> turns(readout);
    Eigen::Matrix<T, 3, 1> turned = Eigen::Matrix<T, 3, 1>::Zero();
    for (int k = Readout::kNumTurns - 1; k >= 0; --k) turned = share * (turned + turns.col(k));
    const Eigen::Matrix<T, 3, 1> seen = world_from_camera.conjugate() * (point - camera_in_world);
    // Cayley's form of the rotation, without its denominator: the scale of x does not matter.
    const Eigen::Matrix<T, 3, 1> x = (T(1.0) - T(0.25) * turned.squaredNorm()) * seen -
                                     turned.cross(seen) + T(0.5) * turned.dot(seen) * turned;
    // A step of the solver may move a point behind the camera. Such a point has no finite
    // projection.
    if (x.z() < T(1e-3)) return false;
    Eigen::Matrix<T, 2, 1> p(x.x() / x.z(), x.y() / x.z());
    p = Distorted(p) + Change(p, lens);
    residual[0] = T(camera->fx_px) * lens[kFocalFactor] * p.x() + cx - T(point_in_image.x());
    residual[1] = T(camera->fy_px) * lens[kFocalFactor] * p.y() + cy - T(point_in_image.y());
    return true;
  }

  const Camera* camera;
  Eigen::Vector2d point_in_image;

 private:
  // Additional distortion from the changes of the coefficients. The model is linear in the
  // coefficients.
  template <typename T>
  static Eigen::Matrix<T, 2, 1> Change(const Eigen::Matrix<T, 2, 1>& p, const T* const lens) {
    const T r2 = p.squaredNorm();
    const T radial = r2 * (lens[kRadial1] + r2 * lens[kRadial2]);
    const T xy = T(2.0) * p.x() * p.y();
    const T &p1 = lens[kTangential1], &p2 = lens[kTangential2];
    return {p.x() * radial + p1 * xy + p2 * (r2 + T(2.0) * p.x() * p.x()),
            p.y() * radial + p1 * (r2 + T(2.0) * p.y() * p.y()) + p2 * xy};
  }

  double Coefficient(size_t i) const {
    return i < camera->coefficients.size() ? camera->coefficients[i] : 0.0;
  }

  template <typename T>
  Eigen::Matrix<T, 2, 1> Distorted(const Eigen::Matrix<T, 2, 1>& p) const {
    const T r2 = p.squaredNorm();
    if (camera->distortion == DistortionModel::kRadTan) {
      const double p1 = Coefficient(2), p2 = Coefficient(3);
      const T radial = T(1.0) + r2 * (Coefficient(0) + r2 * (Coefficient(1) + r2 * Coefficient(4)));
      return {p.x() * radial + 2.0 * p1 * p.x() * p.y() + p2 * (r2 + 2.0 * p.x() * p.x()),
              p.y() * radial + p1 * (r2 + 2.0 * p.y() * p.y()) + 2.0 * p2 * p.x() * p.y()};
    }
    if (camera->distortion == DistortionModel::kEquidistant && r2 > T(1e-16)) {
      using std::atan;
      using std::sqrt;
      const T r = sqrt(r2);
      const T theta = atan(r);
      const T t2 = theta * theta;
      const T scale =
          theta / r *
          (T(1.0) + t2 * (Coefficient(0) +
                          t2 * (Coefficient(1) + t2 * (Coefficient(2) + t2 * Coefficient(3)))));
      return p * scale;
    }
    return p;
  }
};

struct PositionPrior {
  template <typename T>
  bool operator()(const T* const pose, T* residual) const {
    const T* const position = pose + 4;
    for (int i = 0; i < 3; ++i) residual[i] = (position[i] - T(prior_in_world[i])) / T(sd_m);
    return true;
  }

  Eigen::Vector3d prior_in_world;
  double sd_m;
};

// The residual is the rotation vector, in world, from the prior attitude to the adjusted one. Yaw
// (about the vertical) and tilt (about horizontal axes) have separate deviations.
struct AttitudePrior {
  template <typename T>
  bool operator()(const T* const pose, T* residual) const {
    const Eigen::Map<const Eigen::Quaternion<T>> world_from_camera(pose);
    Eigen::Quaternion<T> difference =
        world_from_camera * prior_world_from_camera.conjugate().cast<T>();
    if (difference.w() < T(0.0)) difference.coeffs() = -difference.coeffs();
    // For small angles, the rotation vector is twice the vector part of the quaternion.
    residual[0] = T(2.0) * difference.x() / T(tilt_sd);
    residual[1] = T(2.0) * difference.y() / T(tilt_sd);
    residual[2] = T(2.0) * difference.z() / T(yaw_sd);
    return true;
  }

  Eigen::Quaterniond prior_world_from_camera;
  double tilt_sd;
  double yaw_sd;
};

// Prior: the camera did not move during readout.
struct ReadoutPrior {
  template <typename T>
  bool operator()(const T* const readout, T* residual) const {
    for (int i = 0; i < kNumReadoutParameters; ++i) residual[i] = readout[i] / T(sd[i / 3]);
    return true;
  }

  // Of each power of the turn.
  std::array<double, Readout::kNumTurns> sd;
};

// Prior: the lens stays near its known values.
struct LensPrior {
  template <typename T>
  bool operator()(const T* const lens, T* residual) const {
    for (int i = 0; i < kNumLensParameters; ++i) {
      residual[i] = (lens[i] - T(i == kFocalFactor ? 1.0 : 0.0)) / T(sd[i]);
    }
    return true;
  }

  std::array<double, kNumLensParameters> sd;
};

}  // namespace freelsd
