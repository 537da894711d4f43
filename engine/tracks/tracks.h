// Input: frames with pose priors. Output: posed views joined by feature tracks, and the coarse
// height of the ground at a pixel. Paper: Sec. III-A, III-B.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/flight/flight.h"

namespace freelsd {

struct TracksOptions {
  // --- Behaviour ---
  // Below this predicted displacement between two frames (share of the image width) corners are
  // followed with Kanade-Lucas-Tomasi; above it descriptors are matched. Paper: "depending on the
  // provided framerate", Sec. III-A, no number.
  double max_klt_flow_ratio = 0.15;
  // Corners kept per frame by the tracker, and keypoints per frame by the matcher.
  int max_num_corners = 250;
  int max_num_keypoints = 1500;
  // Images wider than this are matched at reduced size; observations are in full-size pixels. 752
  // is the width of the paper's video camera; survey photographs match as well as at 1000, and
  // faster.
  int matching_width_px = 752;
  // Largest distance of a forward-backward tracked corner from where it started.
  double max_forward_backward_error_px = 1.0;
  // A pair of frames counts as connected from this number of geometrically verified matches on.
  int min_num_verified_matches = 20;
  // Distance of a match from the epipolar line or plane-induced homography that still counts, in
  // pixels of the matching image.
  double max_verification_error_px = 3.0;
  // Earlier views near in place that a survey photograph is matched against, besides its
  // predecessor.
  int max_num_match_partners = 6;
  // Tracks whose landmarks give the height at a pixel. Paper: N, Sec. III-B, no number.
  int num_nearest_tracks = 8;
  // Landmarks with less parallax or more reprojection error are not used.
  double min_parallax_deg = 2.0;
  double max_reprojection_error_px = 12.0;
  // A given attitude that disagrees with the matches by more than this is replaced and warned of
  // (rotated photographs, a gimbal that lies).
  double max_attitude_disagreement_deg = 30.0;
  // Deviation from straight down assumed where no attitude is given.
  double nadir_sd_deg = 8.0;
  // Frames that may wait for enough matches to find their attitude or height.
  int max_num_waiting_frames = 12;
  // Photographs that see the same ground and yet hang together over no tracks are matched once more
  // when their poses are adjusted: at this width, each as seen from straight above.
  // Differs: the paper's video hangs together.
  int ground_matching_width_px = 1200;
  int max_num_ground_keypoints = 3000;
  int min_num_tie_matches = 12;
  // Less of the smaller footprint in common than this is within what tilt and relief may pretend.
  double min_ground_overlap_ratio = 0.02;
  // How far from its place the same ground may be seen, share of the height: poses and relief.
  double max_ground_error_ratio = 0.15;
  // Take the ground as the plane below by height_above_ground (or below take-off). Paper: the
  // footnote's ground plane approximation.
  bool assume_ground_plane = false;

  void Check() const;
};

struct Observation {
  int64_t track_id = 0;
  // Distorted pixel of the full-size image.
  Eigen::Vector2d point_in_image = Eigen::Vector2d::Zero();
};

enum class AttitudeSource {
  kGiven,      // autopilot or gimbal
  kEstimated,  // none given: found from matches
  kCorrected,  // given, but contradicted by matches
};

// A frame whose pose and height above ground are known, without its image.
struct View {
  std::string frame_id;
  int64_t timestamp_us = 0;
  // Best estimate so far.
  Rigid3d world_from_camera;
  Readout readout;
  // What the priors say of the camera, and their deviations: they stay what they were when
  // world_from_camera is replaced, or every adjustment would take the last one's result for
  // granted.
  Eigen::Vector3d prior_position_in_world = Eigen::Vector3d::Zero();
  Eigen::Quaterniond prior_world_from_camera = Eigen::Quaterniond::Identity();
  double position_sd_m = 2.0;
  double attitude_sd_deg = 2.0;
  AttitudeSource attitude_source = AttitudeSource::kGiven;
  // Of the camera over the ground below the image centre, metres.
  double height_above_ground = 0.0;
  std::vector<Observation> observations;
};

// A pixel brought to the ground with coarse depth.
struct GroundPoint {
  Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();
  // Standard deviation of its height from the spread of the landmarks, metres.
  double height_sd_m = 0.0;
};

// A frame that became a view, with its image, or one that was given up.
struct ReadyFrame {
  Frame frame;
  // Index into views(); nothing when the frame was given up.
  std::optional<size_t> view;
  // Why it was given up, or what is worth a warning about it; often empty.
  std::string note;
};

// The views with tracks added that tie those of different groups (one number per view; below zero:
// a view of no group) which see the same ground. The images, seen from straight above with the
// poses and `camera` as adjusted, are matched near where the poses say: this finds what the first
// matching could not (a strip of overlap, another heading). One image at a time is in memory.
std::vector<View> TieOnGround(std::vector<View> views,
                              const std::vector<int>& group,
                              const Camera& camera,
                              const ImageSource& images,
                              const TracksOptions& options);

// Remembers all views of one flight. Frames come in the order of flight. Not thread-safe.
class Tracks {
 public:
  Tracks(const Rig& rig, const TracksOptions& options);
  ~Tracks();
  Tracks(Tracks&&) noexcept;
  Tracks& operator=(Tracks&&) noexcept;

  // Takes one frame. A frame without attitude, or before any height is known, waits until its
  // neighbours tell; so the answer holds none, one or several frames, in order.
  std::vector<ReadyFrame> Add(Frame frame);
  // No more frames for now: those that wait are made views as well as possible or given up.
  std::vector<ReadyFrame> Flush();

  // In order of readiness.
  const std::vector<View>& views() const;
  const Camera& camera() const;
  // Better poses from an adjustment, for views given by index, and better intrinsics.
  void SetPose(size_t view, const Rigid3d& world_from_camera, const Readout& readout);
  void SetCamera(const Camera& camera);

  // Where the ray of a pixel meets the ground: N nearest landmarks, inverse distance weights;
  // else the plane at the view's height above ground. Nothing for a ray at or above the horizon.
  std::optional<GroundPoint> GroundAt(size_t view, const Eigen::Vector2d& point_in_image) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace freelsd
