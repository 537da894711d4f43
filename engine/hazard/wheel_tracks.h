// Private to hazard/. Green crops, by the tracks that a sprayer leaves in them: two ruts side by
// side, and again every working width. All of a sprayed field lies within half a working width of a
// track. Meadows are driven on too, but not again and again in the same tracks.
#pragma once

#include <vector>

#include "engine/hazard/hazard.h"

namespace freelsd {

// Midway between its two ruts; as far as it is straight. World.
struct WheelTrack {
  Eigen::Vector2d start = Eigen::Vector2d::Zero();
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
};

// Every one that is long enough, in no particular order but always the same.
std::vector<WheelTrack> FindWheelTracks(const Orthophoto& photo, const HazardOptions& options);

// Cells of the grid around tracks that have a parallel one beside them: 255, else 0.
cv::Mat1b SprayedGround(const std::vector<WheelTrack>& tracks,
                        const Grid& grid,
                        const HazardOptions& options);

}  // namespace freelsd
