// Input: the poses of two frames, and the height of the ground. Output: the points of one frame in
// the other, followed from where a level plane at that height would show them. All points are
// distorted pixels of the full-size image.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "engine/geometry/geometry.h"
#include "engine/tracks/keypoints.h"

namespace freelsd {

// A frame's image, seen from a pose that may be wrong by some degrees and metres.
struct PosedImage {
  TrackingImage image;
  Camera camera;
  Rigid3d world_from_camera;
};

// Pixel of `to` that shows the ground at a pixel of `from`. Nothing near or above the horizon.
std::optional<Eigen::Vector2d> TransferOverGround(const PosedImage& from,
                                                  const PosedImage& to,
                                                  const Eigen::Vector2d& point_in_from,
                                                  double ground_height);

struct PlaneOverlap {
  // Homography between pixels of both tracking images. Lens distortion is averaged.
  Eigen::Matrix3d to_from_from = Eigen::Matrix3d::Identity();
  // Share of the image `to` whose ground `from` shows too.
  double ratio = 0.0;
};
std::optional<PlaneOverlap> OverlapOverGround(const PosedImage& from,
                                              const PosedImage& to,
                                              double ground_height);

// Positions of the points in `to`; nothing for a lost point. `from` is first warped to the view
// of `to`, so that the patches differ by relief only. `to` must have a pyramid.
std::vector<std::optional<Eigen::Vector2d>> FollowOverGround(
    const PosedImage& from,
    const PosedImage& to,
    const PlaneOverlap& overlap,
    const std::vector<Eigen::Vector2d>& points_in_from,
    const std::vector<Eigen::Vector2d>& guesses_in_to,
    const TracksOptions& options);

// The attitude of `to` with which the found points lie best where they were expected. An error of
// the position, which shifts them nearly alike, is included in the turn.
Eigen::Quaterniond TurnedToFit(const PosedImage& to,
                               const std::vector<Eigen::Vector2d>& expected,
                               const std::vector<Eigen::Vector2d>& found);

}  // namespace freelsd
