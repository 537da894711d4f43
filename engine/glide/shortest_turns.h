// Part of glide.h: shortest path of bounded curvature in the plane (Dubins 1957).
#pragma once

#include <Eigen/Core>

namespace freelsd {

// A place and the direction of travel there. The heading is in radians clockwise from north.
struct Stance {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  double heading = 0.0;
};

// The parts of a path, in the order in which they are flown. Turns are in radians, positive to the
// right. The path has a straight piece or a middle turn, never both.
struct TurnPath {
  double first_turn = 0.0;
  double straight_m = 0.0;
  double middle_turn = 0.0;
  double last_turn = 0.0;

  // Sum of the absolute values of the turns.
  double Turned() const;
};

// The shortest of all paths of the form turn-straight-turn or turn-turn-turn.
TurnPath ShortestTurns(const Stance& from, const Stance& to, double radius_m);

}  // namespace freelsd
