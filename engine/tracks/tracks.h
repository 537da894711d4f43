// Input: frames with pose priors. Output: posed views connected by feature tracks, and the coarse
// height of the ground at a pixel. Paper: Sec. III-A, III-B.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/flight/flight.h"

namespace freelsd {

struct TracksOptions {
  // --- Behaviour ---
  // Largest predicted displacement between two frames, as a share of the image width, at which
  // corners are followed with Kanade-Lucas-Tomasi. At larger displacements, descriptors are
  // matched. Paper: "depending on the provided framerate", Sec. III-A, no number.
  double max_klt_flow_ratio = 0.15;
  // Largest number of corners per frame for the tracker, and of keypoints per frame for the
  // matcher.
  int max_num_corners = 250;
  int max_num_keypoints = 1500;
  // Photographs at larger displacements are linked without descriptors where poses and the height
  // of the ground are known: this number of corners of each is followed from where they predict
  // them. 0: descriptors are always matched.
  int max_num_predicted_corners = 500;
  // Wider images are reduced to this width for matching. The unit of observations is still the
  // pixel of the full-size image. 752 is the width of the paper's video camera. At this width,
  // survey photographs match as well as at 1000, and faster.
  int matching_width_px = 752;
  // Largest distance between a corner and the result of tracking it forward and back again.
  double max_forward_backward_error_px = 1.0;
  // Least number of geometrically verified matches that connect two frames.
  int min_num_verified_matches = 20;
  // Largest error of a verified match, in pixels of the matching image. The error is the distance
  // from the epipolar line, or from the position that the homography of a plane predicts.
  double max_verification_error_px = 3.0;
  // A survey photograph is matched with its predecessor, and also with this number of the nearest
  // earlier views.
  int max_num_match_partners = 6;
  // Number of tracks whose landmarks give the height at a pixel. Paper: N, Sec. III-B, no number.
  int num_nearest_tracks = 8;
  // Landmarks with less parallax or a larger reprojection error are not used.
  double min_parallax_deg = 2.0;
  double max_reprojection_error_px = 12.0;
  // Largest difference between the yaw of a given attitude and the yaw from matches. Beyond it, the
  // attitude is replaced, with a warning. Causes are rotated photographs and faulty gimbal angles.
  double max_attitude_disagreement_deg = 30.0;
  // Standard deviation of the tilt from straight down, for a camera without a given attitude.
  double nadir_sd_deg = 8.0;
  // Largest number of frames that wait for matches from which their attitude or height can be
  // computed.
  int max_num_waiting_frames = 12;
  // Photographs of the same ground without common tracks are matched again during adjustment. Each
  // photograph is resampled to the view from straight above, at this width. At 1200 as many views
  // are tied, in four times the time. Differs: in the paper's video, tracks connect all frames.
  int ground_matching_width_px = 600;
  int max_num_ground_keypoints = 3000;
  int min_num_tie_matches = 12;
  // Least overlap, as a share of the smaller footprint. Tilt and relief alone may cause a smaller
  // computed overlap.
  double min_ground_overlap_ratio = 0.02;
  // Search radius of ground matching, as a share of the height. It covers pose errors and relief.
  double max_ground_error_ratio = 0.15;
  // Views of one block whose footprints share more than this part of the smaller one, and which
  // share fewer than max_num_shared_points points, are tied to each other: each view with at least
  // the num_tie_partners that show most of the same ground. At most num_tie_points of a view are
  // followed into another.
  double min_tie_overlap_ratio = 0.05;
  int max_num_shared_points = 30;
  int num_tie_partners = 10;
  int num_tie_points = 80;
  // After the first adjustment, the sightings of a track are aligned at the photograph's full
  // resolution, if it is larger than matching_width_px. A sighting stays where it is if the
  // alignment moves it farther than this, in pixels of the full-size image, or if the patches are
  // less alike than this.
  double max_alignment_shift_px = 4.0;
  double min_alignment_correlation = 0.7;
  // Assumes that the ground is a level plane. The plane lies height_above_ground below the camera.
  // If that height is not given, the plane lies at take-off height (world z = 0). Paper: the
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

// A frame with known pose and height above ground, without its image.
struct View {
  std::string frame_id;
  int64_t timestamp_us = 0;
  // Best current estimate.
  Rigid3d world_from_camera;
  Readout readout;
  // Prior of the camera, and its deviations. They do not change when world_from_camera changes.
  // Otherwise every adjustment would take the previous result as an independent measurement.
  Eigen::Vector3d prior_position_in_world = Eigen::Vector3d::Zero();
  Eigen::Quaterniond prior_world_from_camera = Eigen::Quaterniond::Identity();
  double position_sd_m = 2.0;
  double attitude_sd_deg = 2.0;
  AttitudeSource attitude_source = AttitudeSource::kGiven;
  // Height of the camera above the ground below the image centre, metres.
  double height_above_ground = 0.0;
  std::vector<Observation> observations;
};

// The ground point that a pixel shows, from coarse depth.
struct GroundPoint {
  Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();
  // Standard deviation of the height, from the spread of the landmarks, metres.
  double height_sd_m = 0.0;
};

// A frame, with its image, that has become a view or was dropped.
struct ReadyFrame {
  Frame frame;
  // Index into views(); nothing if the frame was dropped.
  std::optional<size_t> view;
  // Why the frame was dropped, or a warning about it; often empty.
  std::string note;
};

// Adds tracks between views of different groups, and returns all views. `group` has one number per
// view; negative: no group. The adjusted poses and `camera` are used to resample each image to the
// view from straight above. The images are then matched near the positions that the poses predict.
// This finds matches in narrow overlaps and between different headings. Holds one image per core in
// memory.
std::vector<View> TieOnGround(std::vector<View> views,
                              const std::vector<int>& group,
                              const Camera& camera,
                              const ImageSource& images,
                              const TracksOptions& options);

// World points of tracks, by track id.
using TrackPoints = std::map<int64_t, Eigen::Vector3d>;

// Continues tracks into every other view that shows their points, and returns all views. Pairs of
// views whose footprints overlap and which share fewer than max_num_shared_points are tied: points
// of one are followed from where the adjusted poses predict them in the other. This ties strips
// along their whole length; `points` must be those of one block, in the frame of the poses. Holds
// one reduced image per view in memory.
std::vector<View> FollowIntoOverlaps(std::vector<View> views,
                                     const TrackPoints& points,
                                     const Camera& camera,
                                     const ImageSource& images,
                                     const TracksOptions& options);

// Aligns the sightings of each track with its sighting nearest to the image centre, by the grey
// values of the full-size photographs. Keypoints are found in reduced photographs, with an error of
// about half a pixel of the full-size one. The poses are used for scale, rotation and perspective
// of the patches. Holds one image per core in memory, and one patch per track.
std::vector<View> AlignSightings(std::vector<View> views,
                                 const Camera& camera,
                                 const ImageSource& images,
                                 const TracksOptions& options);

// Remembers all views of one flight. Expects frames in flight order. Not thread-safe.
class Tracks {
 public:
  Tracks(const Rig& rig, const TracksOptions& options);
  ~Tracks();
  Tracks(Tracks&&) noexcept;
  Tracks& operator=(Tracks&&) noexcept;

  // Adds one frame. A frame waits for its neighbours if its attitude or its height is unknown. The
  // result contains zero, one or several frames.
  std::vector<ReadyFrame> Add(Frame frame);
  // Ends the waiting of all frames. Frames whose attitude and height can be computed become views.
  // The others are dropped.
  std::vector<ReadyFrame> Flush();

  // In the order in which the frames became views.
  const std::vector<View>& views() const;
  const Camera& camera() const;
  // Sets the pose of a view (by index) from an adjustment. Trap: the refined lens of an adjustment
  // is not taken over. It is valid only for the views of that adjustment.
  void SetPose(size_t view, const Rigid3d& world_from_camera, const Readout& readout);

  // Where the ray through a pixel meets the ground. The height of the ground is the
  // inverse-distance weighted mean of the num_nearest_tracks nearest landmarks. With too few
  // landmarks, the ground is a level plane at the view's height above ground. Nothing at or above
  // the horizon.
  std::optional<GroundPoint> GroundAt(size_t view, const Eigen::Vector2d& point_in_image) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace freelsd
