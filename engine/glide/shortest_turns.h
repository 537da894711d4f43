// Private to glide/: shortest path of bounded curvature in the plane (Dubins 1957).
#pragma once

#include <Eigen/Core>

namespace freelsd {

// A place and a direction of travel there, radians clockwise from north.
struct Stance {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  double heading = 0.0;
};

struct TurnPath {
  // Sum of the two or three arcs, radians, and length of the straight piece.
  double turned = 0.0;
  double straight_m = 0.0;
};

// The shortest of turn-straight-turn and turn-turn-turn.
TurnPath ShortestTurns(const Stance& from, const Stance& to, double radius_m);

}  // namespace freelsd
