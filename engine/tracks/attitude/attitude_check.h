// Input: frames with attitudes, and their matches. Output: the rotation that corrects a wrong
// attitude (photographs rotated after exposure, faulty gimbal angles).
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

// Rotation about the vertical, in radians counter-clockwise from above, that makes the matches of
// two frames coincide on level ground.
struct TurnEvidence {
  // Rotation of frame b if the attitude of frame a is correct.
  double turn_of_b_against_a = 0.0;
  // Rotation of each frame according to the GPS baseline; nothing if the baseline is too short.
  std::optional<double> turn_of_a;
  std::optional<double> turn_of_b;
};
std::optional<TurnEvidence> CompareAttitudes(const OrientedFrame& a,
                                             const OrientedFrame& b,
                                             const AlignmentPair& matches);

// Combines the rotations from all pairs of a frame. Returns the rotation with the least sum of
// differences from the others. Nothing if `turns` is empty.
std::optional<double> MedianTurn(const std::vector<double>& turns);

}  // namespace freelsd
