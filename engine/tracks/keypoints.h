// Input: a frame's image. Output: corners followed from the frame before, or described keypoints.
// Points are distorted pixels of the full-size image throughout.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "engine/tracks/tracks.h"

namespace freelsd {

// The grey image that tracking works on: at most matching_width_px wide.
struct TrackingImage {
  cv::Mat grey;
  // Tracking pixels per full-size pixel; at most 1.
  double scale = 1.0;
  // For following corners; empty until some are.
  std::vector<cv::Mat> pyramid = {};

  Eigen::Vector2d FullFromReduced(const cv::Point2f& point) const;
  cv::Point2f ReducedFromFull(const Eigen::Vector2d& point) const;
};
TrackingImage ReduceForTracking(const cv::Mat& image, const TracksOptions& options);

// New corners, spread evenly, away from those there are already.
std::vector<Eigen::Vector2d> FindCorners(const TrackingImage& image,
                                         const std::vector<Eigen::Vector2d>& existing,
                                         const TracksOptions& options);

// The same image with its pyramid, which serves twice: to its predecessor and to its successor.
TrackingImage WithPyramid(TrackingImage image);

// Where the points of one frame are in the next, both with their pyramids; nothing for a point that
// was lost. `guesses` are their predicted places, or empty.
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
