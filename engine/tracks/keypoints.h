// Input: a frame's image. Output: corners followed from the previous frame, or keypoints with
// descriptors. All points are distorted pixels of the full-size image.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "engine/tracks/tracks.h"

namespace freelsd {

// Grey image for tracking, at most matching_width_px wide.
struct TrackingImage {
  cv::Mat grey;
  // Tracking pixels per full-size pixel; at most 1.
  double scale = 1.0;
  // For following corners; empty until WithPyramid is called.
  std::vector<cv::Mat> pyramid = {};

  Eigen::Vector2d FullFromReduced(const cv::Point2f& point) const;
  cv::Point2f ReducedFromFull(const Eigen::Vector2d& point) const;
};
TrackingImage ReduceForTracking(const cv::Mat& image, const TracksOptions& options);

// New corners, evenly spread, away from existing ones; at most `max_count` with these.
std::vector<Eigen::Vector2d> FindCorners(const TrackingImage& image,
                                         const std::vector<Eigen::Vector2d>& existing,
                                         int max_count);

// Adds the pyramid, which is needed twice: for the previous and for the next frame.
TrackingImage WithPyramid(TrackingImage image);

// Positions in the image `to`; nothing for a lost point. Both images must have pyramids. `guesses`
// contains predicted positions, or is empty.
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
