// Input: matches of two frames. Output: matches consistent with two views of one ground.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace freelsd {

// Indices of the matches that agree with one plane-induced homography, or with the epipolar
// geometry and a believable relief about that plane. Points are ideal (undistorted) pixels of the
// matching image. Empty when fewer than `min_count` agree with the homography.
std::vector<int> VerifyMatches(const std::vector<Eigen::Vector2d>& points_a,
                               const std::vector<Eigen::Vector2d>& points_b,
                               double max_error_px,
                               int min_count);

}  // namespace freelsd
