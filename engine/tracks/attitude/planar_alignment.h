// Input: matched frames of near-nadir cameras without attitude, over locally level ground, with GPS
// positions. Output: their attitudes and heights above ground.
//
// Differs: the paper has the autopilot's attitude. Without one, a normalised image point is
// written as the complex number z = x - i y (right and up in the image, seen from above). Its place
// on the ground is
//   place = p + c + a z     (east + i north)
// p: position of the camera. arg a: rotation of the image's top from north, counter-clockwise. |a|:
// height above ground. c: offset of the optical axis due to tilt. Every match gives one equation:
// the places of its two points are equal. The equation is linear in a and c. Therefore no initial
// heading is needed. The solution is then refined with the exact projection.
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
  // A held frame has a known pose, which stays unchanged. The poses of other frames are computed.
  bool is_held = false;
  Eigen::Quaterniond world_from_camera = Eigen::Quaterniond::Identity();
  double height_above_ground = 0.0;
  // Radians, from the normal equations; 0 for held frames.
  double heading_sd = 0.0;
  // True if the computed pose of this frame is trusted.
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

// The pairs must connect all frames. Returns the frames in the same order. is_solved stays false
// for frames with too little baseline, or with implausible tilt or residuals.
std::vector<AlignmentFrame> AlignToGround(std::vector<AlignmentFrame> frames,
                                          const std::vector<AlignmentPair>& pairs,
                                          const AlignmentOptions& options);

}  // namespace freelsd
