// Input: frames with attitudes, and their matches. Output: which attitude is turned against the
// ground (photographs rotated after exposure, a gimbal that lies).
#pragma once

#include <optional>
#include <vector>

#include "engine/tracks/planar_alignment.h"

namespace freelsd {

struct OrientedFrame {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  double position_sd_m = 2.0;
  Eigen::Quaterniond world_from_camera = Eigen::Quaterniond::Identity();
  double attitude_sd = 0.0;
};

// How far the attitudes of two frames must be turned about the vertical (counter-clockwise from
// above) so that their matches fall on the same level ground.
struct TurnEvidence {
  // Of b, if a is right.
  double turn_of_b_against_a = 0.0;
  // Of either, by the direction of the GPS baseline; nothing where the baseline is too short.
  std::optional<double> turn_of_a;
  std::optional<double> turn_of_b;
};
std::optional<TurnEvidence> CompareAttitudes(const OrientedFrame& a,
                                             const OrientedFrame& b,
                                             const AlignmentPair& matches);

// The turn a frame needs, of what its pairs say: the one nearest to all others.
std::optional<double> MedianTurn(const std::vector<double>& turns);

}  // namespace freelsd
