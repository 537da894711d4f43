// Input: frames with poses, connected by tracks. Output: landmarks and the height of the ground.
// Paper: Sec. III-B.
#pragma once

#include <optional>
#include <vector>

#include "engine/tracks/frame_memory.h"

namespace freelsd {

// A track seen by a frame, triangulated with the current poses.
struct CoarseLandmark {
  Eigen::Vector2d point_in_image = Eigen::Vector2d::Zero();
  Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();
  // Largest angle between its rays, radians.
  double parallax = 0.0;
};
// Of at least one value; the upper one of two.
double Median(std::vector<double> values);

// Skips landmarks with too little parallax, too large a reprojection error, or a point above the
// camera or too far from the ground.
std::vector<CoarseLandmark> TriangulateLandmarks(const FrameMemory& memory, size_t frame);

// Height of the ground from one frame's landmarks, world z.
struct GroundHeight {
  double z = 0.0;
  double sd_m = 0.0;
};
std::optional<GroundHeight> GroundFromLandmarks(const std::vector<CoarseLandmark>& landmarks,
                                                const FrameRecord& record);

// Intersects a pixel's ray with a horizontal plane. Nothing if the ray is less than 3 deg below the
// horizon or the plane is not below the camera.
std::optional<Eigen::Vector3d> IntersectGround(const Camera& camera,
                                               const Rigid3d& world_from_camera,
                                               const Eigen::Vector2d& point_in_image,
                                               double ground_height);

// Inverse-distance weighted mean height of the landmarks nearest to the pixel, and the deviation of
// these heights; nothing if there are too few landmarks.
std::optional<GroundHeight> HeightNear(const std::vector<CoarseLandmark>& landmarks,
                                       const Eigen::Vector2d& point_in_image,
                                       int num_nearest);

}  // namespace freelsd
