// Private to cover/. Finds green crops by the wheel tracks of sprayers. A track is a pair of ruts;
// the next track is one working width of the sprayer away. Sprayed ground lies within half a
// working width of a track. Vehicles also cross meadows, but rarely twice in the same tracks.
#pragma once

#include <vector>

#include "engine/cover/cover.h"

namespace freelsd {

// A straight line midway between two ruts, in world coordinates.
struct WheelTrack {
  Eigen::Vector2d start = Eigen::Vector2d::Zero();
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
};

// All tracks of at least min_track_length_m, in a deterministic order.
std::vector<WheelTrack> FindWheelTracks(const Orthophoto& photo, const CoverOptions& options);

// Ground around tracks that have a parallel neighbour. One value per cell of `grid`: 255 for such
// ground, else 0.
cv::Mat1b SprayedGround(const std::vector<WheelTrack>& tracks,
                        const Grid& grid,
                        const CoverOptions& options);

}  // namespace freelsd
