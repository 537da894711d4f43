// Private to cover/. Finds green crops by a sprayer's wheel tracks: pairs of ruts, repeated every
// working width. Sprayed ground lies within half a working width of a track. Vehicles cross meadows
// too, but seldom in the same tracks.
#pragma once

#include <vector>

#include "engine/cover/cover.h"

namespace freelsd {

// The line midway between two ruts, where it is straight. World.
struct WheelTrack {
  Eigen::Vector2d start = Eigen::Vector2d::Zero();
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
};

// All tracks that are long enough, in a deterministic order.
std::vector<WheelTrack> FindWheelTracks(const Orthophoto& photo, const CoverOptions& options);

// Cells of the grid around tracks with a parallel neighbour: 255, else 0.
cv::Mat1b SprayedGround(const std::vector<WheelTrack>& tracks,
                        const Grid& grid,
                        const CoverOptions& options);

}  // namespace freelsd
