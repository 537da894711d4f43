// Pinhole camera with lens distortion.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

namespace freelsd {

enum class DistortionModel {
  kNone,         // no coefficients
  kRadTan,       // Brown: k1, k2, p1, p2[, k3], as OpenCV
  kEquidistant,  // Kannala-Brandt: k1, k2, k3, k4, as OpenCV fisheye
};

// Source of the intrinsics; only intrinsics from EXIF may be refined.
enum class CameraSource { kCalibrated, kExif };

// Motion of the camera while the rows of one image are read (rolling shutter). A row's time is its
// share: (row - cy) / height of the image. The middle row has share 0.
struct Readout {
  static constexpr int kNumTurns = 5;
  // Column k is the factor of share^(k + 1) in TurnAt. Column 0 is a uniform turn; the others are
  // caused by gusts. Translation along the ground has nearly the same effect on the image and is
  // included.
  Eigen::Matrix<double, 3, kNumTurns> turns = Eigen::Matrix<double, 3, kNumTurns>::Zero();

  static Readout Turning(const Eigen::Vector3d& turn,
                         const Eigen::Vector3d& bend = Eigen::Vector3d::Zero());
  bool IsGlobal() const { return turns.isZero(0.0); }
  // Rotation of the camera from the middle row to another row, camera frame: a vector along the
  // axis, its length is twice the tangent of half the angle (radians if small).
  Eigen::Vector3d TurnAt(double share) const;
};

struct Camera {
  int width_px = 0;
  int height_px = 0;
  double fx_px = 0.0;
  double fy_px = 0.0;
  // Principal point; (0, 0) is the centre of the top-left pixel.
  double cx_px = 0.0;
  double cy_px = 0.0;
  DistortionModel distortion = DistortionModel::kNone;
  std::vector<double> coefficients;
  CameraSource source = CameraSource::kCalibrated;
  // Time from reading the first row to reading the last row, seconds; 0 if all rows are exposed at
  // once or if the time is unknown.
  double readout_s = 0.0;
  // Differs from image to image.
  Readout readout;

  // Pixel of a point in the camera frame; nothing for a point behind the camera, or so far off-axis
  // that the distortion is no longer invertible.
  std::optional<Eigen::Vector2d> ImageFromCamera(const Eigen::Vector3d& point_in_camera) const;
  // Undistorted direction (x / z, y / z) of a pixel. Inverts the distortion by Newton iteration.
  Eigen::Vector2d NormalizedFromImage(const Eigen::Vector2d& point_in_image) const;
  // Unit ray in the camera frame.
  Eigen::Vector3d RayFromImage(const Eigen::Vector2d& point_in_image) const;
  bool IsInside(const Eigen::Vector2d& point_in_image, double margin_px = 0.0) const;
  double MeanFocalPx() const { return 0.5 * (fx_px + fy_px); }
  // The camera for the image resized by `factor`, where pixel areas are averaged.
  Camera Scaled(double factor) const;

  // The same camera with the readout of one image.
  Camera With(const Readout& readout_of_image) const;

  // Throws std::invalid_argument: "camera.fx_px = 0: must be positive".
  void Check() const;
};

}  // namespace freelsd
