// Planar rectification of two posed views: both then look in the same direction, and their rows are
// epipolar lines. Fusiello, Trucco, Verri: A compact algorithm for rectification of stereo pairs,
// 2000.
#pragma once

#include <optional>

#include "engine/stereo/stereo.h"

namespace freelsd {

// Range of depths of the ground, along the optical axis of the rectified pair.
struct DepthRange {
  double nearest = 0.0;
  double typical = 0.0;
  double farthest = 0.0;
};

struct RectifiedPair {
  // Pose of the left camera. The right camera is displaced by `baseline` along the rectified x
  // axis.
  Rigid3d world_from_left;
  double baseline = 0.0;
  double focal_px = 0.0;
  // Principal points. The right one is shifted so that the typical depth has disparity 0.
  double left_cx_px = 0.0;
  double right_cx_px = 0.0;
  double cy_px = 0.0;
  cv::Mat1b left;
  cv::Mat1b right;
  // Non-zero inside the original image. Outside, left and right are black.
  cv::Mat1b is_left_inside;
  cv::Mat1b is_right_inside;

  // Converts a depth to a disparity (left column minus right column), and back.
  double DisparityOf(double depth) const;
  double DepthOf(double disparity_px) const;
};

// Depths along the rectified axis. They are those of the landmarks that both views see, without
// outliers. If there are too few such landmarks, the height above ground is used. The range is
// widened by relief_margin_m.
DepthRange DepthsOf(const AdjustedBlock& block,
                    const StereoPair& pair,
                    const StereoOptions& options);

// Nothing if the views share no ground, if they have no baseline across their mean optical axis, or
// if the rectified image would be too small or too large. Throws std::invalid_argument if an image
// does not fit the camera.
std::optional<RectifiedPair> RectifyPair(const AdjustedBlock& block,
                                         const StereoPair& pair,
                                         const cv::Mat& left_image,
                                         const cv::Mat& right_image,
                                         const StereoOptions& options);

}  // namespace freelsd
