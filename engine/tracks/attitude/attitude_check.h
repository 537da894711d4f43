// Input: frames with attitudes, and their matches. Output: the turn that corrects a wrong attitude
// (photographs rotated after exposure, faulty gimbal angles).
#pragma once

#include <optional>
#include <vector>

#include "engine/tracks/attitude/planar_alignment.h"

namespace freelsd {

struct OrientedFrame {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  double position_sd_m = 2.0;
  Eigen::Quaterniond world_from_camera = Eigen::Quaterniond::Identity();
  double attitude_sd = 0.0;
};

// Turn about the vertical (counter-clockwise from above) that makes the matches of two frames meet
// on level ground.
struct TurnEvidence {
  // Turn of b if a is right.
  double turn_of_b_against_a = 0.0;
  // Turn of either frame by the GPS baseline; nothing if the baseline is too short.
  std::optional<double> turn_of_a;
  std::optional<double> turn_of_b;
};
std::optional<TurnEvidence> CompareAttitudes(const OrientedFrame& a,
                                             const OrientedFrame& b,
                                             const AlignmentPair& matches);

// The turn of a frame from the turns of its pairs: the one nearest to all others.
std::optional<double> MedianTurn(const std::vector<double>& turns);

}  // namespace freelsd
