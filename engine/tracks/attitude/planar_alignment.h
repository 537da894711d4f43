// Input: matched frames of near-nadir cameras without attitude, over locally level ground, with GPS
// positions. Output: their attitudes and heights above ground.
//
// Differs: the paper has an autopilot's attitude. Without one, a normalised image point, read as
// the complex number z = x - i y (the image seen from above, right and up), lies on the ground at
//   place = p + c + a z     (east + i north)
// with p the position, arg a the turn of the image against north, |a| the height above ground and c
// the offset of the optical axis by tilt. Every match gives place_a = place_b, linear in a and c:
// no first guess of a heading is needed. The solution is then refined with the exact projection.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/geometry/geometry.h"

namespace freelsd {

struct AlignmentFrame {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  double position_sd_m = 2.0;
  // A held frame has a known pose; the others are solved.
  bool is_held = false;
  Eigen::Quaterniond world_from_camera = Eigen::Quaterniond::Identity();
  double height_above_ground = 0.0;
  // From the equations; 0 for held frames.
  double heading_sd = 0.0;
  // Whether the solution of this frame is trusted.
  bool is_solved = false;
};

struct AlignmentPair {
  size_t a = 0;
  size_t b = 0;
  // Ideal directions x / z, y / z in the camera frame.
  std::vector<Eigen::Vector2d> points_a;
  std::vector<Eigen::Vector2d> points_b;
};

struct AlignmentOptions {
  double nadir_sd = 0.0;
  double max_heading_sd = 0.0;
};

// The pairs must connect all frames. Returns the frames in the same order. Untrusted frames (too
// little baseline, implausible tilt or residuals) are not solved.
std::vector<AlignmentFrame> AlignToGround(std::vector<AlignmentFrame> frames,
                                          const std::vector<AlignmentPair>& pairs,
                                          const AlignmentOptions& options);

}  // namespace freelsd
