// Input: matches of two frames. Output: matches that are consistent with two views of the same
// ground.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace freelsd {

// Indices of the matches that agree with one plane-induced homography, or with the epipolar
// geometry and a plausible relief about that plane. Points are undistorted pixels of the matching
// image. Empty if fewer than `min_count` agree with the homography.
std::vector<int> VerifyMatches(const std::vector<Eigen::Vector2d>& points_a,
                               const std::vector<Eigen::Vector2d>& points_b,
                               double max_error_px,
                               int min_count);

}  // namespace freelsd
