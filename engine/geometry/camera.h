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

// Where the intrinsics come from; only intrinsics from EXIF may be refined.
enum class CameraSource { kCalibrated, kExif };

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

  // Pixel of a point in the camera frame; nothing for a point behind the camera or so far off-axis
  // that the distortion model folds back.
  std::optional<Eigen::Vector2d> ImageFromCamera(const Eigen::Vector3d& point_in_camera) const;
  // Ideal direction (x / z, y / z) of a pixel. Inverts the distortion by Newton iteration.
  Eigen::Vector2d NormalizedFromImage(const Eigen::Vector2d& point_in_image) const;
  // Unit ray in the camera frame.
  Eigen::Vector3d RayFromImage(const Eigen::Vector2d& point_in_image) const;
  bool IsInside(const Eigen::Vector2d& point_in_image, double margin_px = 0.0) const;
  double MeanFocalPx() const { return 0.5 * (fx_px + fy_px); }
  // The camera of the same image resized by `factor` (pixel areas averaged).
  Camera Scaled(double factor) const;

  // Throws std::invalid_argument: "camera.fx_px = 0: must be positive".
  void Check() const;
};

}  // namespace freelsd
