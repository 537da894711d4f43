// Input: a frame's image. Output: corners followed from the frame before, or described keypoints.
// Points are distorted pixels of the full-size image throughout.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "engine/tracks/tracks.h"

namespace freelsd {

// The grey image for tracking: at most matching_width_px wide.
struct TrackingImage {
  cv::Mat grey;
  // Tracking pixels per full-size pixel; at most 1.
  double scale = 1.0;
  // For following corners; empty until needed.
  std::vector<cv::Mat> pyramid = {};

  Eigen::Vector2d FullFromReduced(const cv::Point2f& point) const;
  cv::Point2f ReducedFromFull(const Eigen::Vector2d& point) const;
};
TrackingImage ReduceForTracking(const cv::Mat& image, const TracksOptions& options);

// New corners, evenly spread, away from existing ones.
std::vector<Eigen::Vector2d> FindCorners(const TrackingImage& image,
                                         const std::vector<Eigen::Vector2d>& existing,
                                         const TracksOptions& options);

// Adds the pyramid, which is used twice: for the predecessor and for the successor.
TrackingImage WithPyramid(TrackingImage image);

// Positions in the next frame (both images with pyramids); nothing for a lost point. `guesses` are
// predicted positions, or empty.
std::vector<std::optional<Eigen::Vector2d>> FollowCorners(
    const TrackingImage& from,
    const TrackingImage& to,
    const std::vector<Eigen::Vector2d>& points,
    const std::vector<Eigen::Vector2d>& guesses,
    const TracksOptions& options);

// Root-SIFT descriptors (Arandjelovic and Zisserman 2012), one row of 128 bytes per point.
struct DescribedPoints {
  std::vector<Eigen::Vector2d> points;
  cv::Mat descriptors;
};
DescribedPoints DescribeKeypoints(const TrackingImage& image, const TracksOptions& options);

}  // namespace freelsd
