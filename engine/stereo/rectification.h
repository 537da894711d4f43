// Planar rectification of two posed views: both look along one direction, rows are epipolar lines.
// Fusiello, Trucco, Verri: A compact algorithm for rectification of stereo pairs, 2000.
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
  // Pose of the left camera. The right camera is `baseline` further along the rectified x axis.
  Rigid3d world_from_left;
  double baseline = 0.0;
  double focal_px = 0.0;
  // Principal points. The right one is shifted so that the typical depth has disparity 0.
  double left_cx_px = 0.0;
  double right_cx_px = 0.0;
  double cy_px = 0.0;
  cv::Mat1b left;
  cv::Mat1b right;
  // Non-zero inside the original image; elsewhere left and right are black.
  cv::Mat1b is_left_inside;
  cv::Mat1b is_right_inside;

  // Disparity (left column minus right column) of a depth, and back.
  double DisparityOf(double depth) const;
  double DepthOf(double disparity_px) const;
};

// Depths of landmarks that both views see, plus the relief margin; else around the height above
// ground. Measured along the rectified pair's axis.
DepthRange DepthsOf(const AdjustedBlock& block,
                    const StereoPair& pair,
                    const StereoOptions& options);

// Nothing if the views share no ground, or no baseline across their axis.
std::optional<RectifiedPair> RectifyPair(const AdjustedBlock& block,
                                         const StereoPair& pair,
                                         const cv::Mat& left_image,
                                         const cv::Mat& right_image,
                                         const StereoOptions& options);

}  // namespace freelsd
