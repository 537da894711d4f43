// Input: a camera, its pose, and between which heights the ground lies. Output: the ground that the
// image shows.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "engine/geometry/geometry.h"

namespace freelsd {

// Of the heights that are known (not NaN); lowest_m > highest_m if none is.
struct HeightRange {
  double lowest_m = 0.0;
  double highest_m = 0.0;

  bool IsEmpty() const { return lowest_m > highest_m; }
};
HeightRange HeightRangeOf(const cv::Mat1f& heights);

// East-north box of the ground between two heights (world z) that the image shows; empty if
// min > max. Everything if the image shows the horizon.
struct Footprint {
  Eigen::Vector2d min_in_world, max_in_world;
};
Footprint FootprintOf(const Camera& camera,
                      const Rigid3d& world_from_camera,
                      double lowest_m,
                      double highest_m);

// Where the rays of the image's corners meet level ground, east-north, clockwise in the image from
// its top left corner. Empty if a ray is flat (near the horizon).
std::vector<Eigen::Vector2d> CornersOnGround(const Camera& camera,
                                             const Rigid3d& world_from_camera,
                                             double height_above_ground);

}  // namespace freelsd
