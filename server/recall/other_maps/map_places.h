// Horizontal places of one map's world in another's. Private to other_maps.
#pragma once

#include <vector>

#include "engine/flight/flight.h"
#include "engine/terrain/terrain.h"

namespace freelsd {

// The two planes are tangent within kilometres of each other, so that the map is affine.
class Places {
 public:
  // `around`: a place near those that are asked for.
  Places(const LocalFrame& from, const LocalFrame& to, const Eigen::Vector2d& around);
  Eigen::Vector2d operator()(const Eigen::Vector2d& place) const {
    return shift_ + rotation_ * (place - around_);
  }

 private:
  Eigen::Vector2d around_, shift_;
  Eigen::Matrix2d rotation_;
};

Eigen::Vector2d MiddleOf(const Grid& grid);

// Greatest height of the cells within `half` cells of each; kNoGround where none of them is seen.
inline constexpr float kNoGround = -1e30f;
cv::Mat1f HighestWithin(const cv::Mat1f& heights, int half);

// The value at this rank of the sorted ones, 0..1. Reorders them; there is at least one.
float ValueAtRank(std::vector<float>& values, double rank);

}  // namespace freelsd
