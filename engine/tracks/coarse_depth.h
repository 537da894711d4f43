// Input: frames with poses, joined by tracks. Output: landmarks, and the ground they tell of.
// Paper: Sec. III-B.
#pragma once

#include <optional>
#include <vector>

#include "engine/tracks/frame_memory.h"

namespace freelsd {

// A track seen by a frame, triangulated with the poses of now.
struct CoarseLandmark {
  Eigen::Vector2d point_in_image = Eigen::Vector2d::Zero();
  Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();
  // Largest angle between its rays, radians.
  double parallax = 0.0;
};
// Landmarks with too little parallax, too much reprojection error, or that no camera can have seen
// are left out.
std::vector<CoarseLandmark> TriangulateLandmarks(const FrameMemory& memory, size_t frame);

// Height of the ground, world z, as one frame's landmarks tell it.
struct GroundHeight {
  double z = 0.0;
  double sd_m = 0.0;
};
std::optional<GroundHeight> GroundFromLandmarks(const std::vector<CoarseLandmark>& landmarks,
                                                const FrameRecord& record);

// Ray of a pixel to a horizontal plane; nothing at or above the horizon.
std::optional<Eigen::Vector3d> IntersectGround(const Camera& camera,
                                               const Rigid3d& world_from_camera,
                                               const Eigen::Vector2d& point_in_image,
                                               double ground_height);

// Inverse-distance weighted mean height of the landmarks nearest to the pixel, and their spread;
// nothing when there are too few.
std::optional<GroundHeight> HeightNear(const std::vector<CoarseLandmark>& landmarks,
                                       const Eigen::Vector2d& point_in_image,
                                       int num_nearest);

}  // namespace freelsd
