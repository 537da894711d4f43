// Planar rectification of two posed views: both look along one direction, rows are epipolar lines.
// Fusiello, Trucco, Verri: A compact algorithm for rectification of stereo pairs, 2000.
#pragma once

#include <optional>

#include "engine/stereo/stereo.h"

namespace freelsd {

// Depths between which the ground lies, along the optical axis of the rectified pair.
struct DepthRange {
  double nearest = 0.0;
  double typical = 0.0;
  double farthest = 0.0;
};

struct RectifiedPair {
  // Of the left camera; the right one is baseline further along the rectified x axis.
  Rigid3d world_from_left;
  double baseline = 0.0;
  double focal_px = 0.0;
  // Principal points; the right one is shifted so that typical depth has disparity 0.
  double left_cx_px = 0.0;
  double right_cx_px = 0.0;
  double cy_px = 0.0;
  cv::Mat1b left;
  cv::Mat1b right;
  // Non-zero where there is an image; elsewhere left and right are black.
  cv::Mat1b is_left_inside;
  cv::Mat1b is_right_inside;

  // Disparity (left column minus right column) of a depth, and back.
  double DisparityOf(double depth) const;
  double DepthOf(double disparity_px) const;
};

// Depths of the landmarks that both views see, with the relief margin; else around the height above
// ground. The axis is that of the rectified pair.
DepthRange DepthsOf(const AdjustedBlock& block,
                    const StereoPair& pair,
                    const StereoOptions& options);

// Nothing when the views share no ground, or have no baseline across their axis.
std::optional<RectifiedPair> RectifyPair(const AdjustedBlock& block,
                                         const StereoPair& pair,
                                         const cv::Mat& left_image,
                                         const cv::Mat& right_image,
                                         const StereoOptions& options);

}  // namespace freelsd
