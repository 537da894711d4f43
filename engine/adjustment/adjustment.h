// Input: views joined by tracks. Output: key-frames, and refined metric poses. Paper: Sec. III-F.
#pragma once

#include <string>
#include <vector>

#include "engine/tracks/tracks.h"

namespace freelsd {

struct AdjustmentOptions {
  // --- Behaviour ---
  // Frames are skipped while they share at least this many tracks with the last key-frame. The last
  // skipped frame becomes the next key-frame. Paper: 30, Sec. III-F.
  int min_num_track_connections = 30;
  // Least baseline between key-frames. Paper: "larger than a minimal baseline", no number.
  double min_baseline_m = 8.0;
  // A frame is not skipped if its baseline from the last key-frame is more than this share of its
  // height above ground. Differs: our corners are spread evenly over the image. With the paper's
  // rule alone, neighbouring key-frames overlap by only an eighth, which is too little for stereo.
  // With 0.3, ground at the ends of a strip is seen by one pair alone, which nothing checks.
  double max_baseline_ratio = 0.2;
  // Width of the robust loss function (Cauchy).
  double robust_loss_px = 1.5;
  // Observations with a larger error after the first solve are dropped before the second.
  double max_reprojection_error_px = 6.0;
  // After the last solve, observations with an error of more than this many deviations are dropped
  // too. The deviation, along one axis, is computed from the median error of the block. Source:
  // normal errors reach 6 deviations once in 10^8, so the dropped ones are wrong matches.
  double max_reprojection_error_sigma = 6.0;
  // Refines a lens that is known from EXIF. The fields with _sd are the deviations of its priors.
  // Focal length and first radial coefficient are always refined. The other parameters are refined
  // only with min_num_lens_views or more views, because fewer views cannot separate them from tilt
  // (decision 0007). The deviation of the principal point is a share of the focal length. Differs:
  // the paper's cameras are calibrated.
  bool refine_exif_intrinsics = true;
  int min_num_lens_views = 20;
  double focal_sd_ratio = 0.05;
  double radial_sd = 0.1;
  double tangential_sd = 0.01;
  double principal_point_sd_ratio = 0.03;
  // Prior deviation of the camera's angular rate while a rolling shutter reads one image. The
  // estimated rate also contains the shift of the image that the forward flight causes. In a survey
  // photograph this shift may be a hundred pixels during readout. Differs: the paper's shutters are
  // global. Trap: a larger deviation may stretch the block if all views look straight down on flat
  // ground.
  double readout_rate_sd_deg_s = 8.0;
  // Prior deviation of the change of that rate during readout. Gusts cause such changes. Higher
  // powers of time get the prior that allows the same turn at the first and at the last row.
  double readout_change_sd_deg_s2 = 400.0;
  // Highest power of time in the turn during readout, in [1, 5]. Each power is kept only if
  // Schwarz's criterion (BIC) justifies its parameters. In the gyroscope records of 28 photographs
  // of 0.16 s, powers 1 to 5 leave 7.2, 3.1, 1.0, 0.6 and 0.3 px (decision 0027).
  int max_readout_power = 5;
  // Readout time assumed for a camera that is known only from EXIF. 0: global shutter. The motion
  // during readout is estimated. The estimate is kept only if Schwarz's criterion (BIC) justifies
  // its parameters. Otherwise it could bend the block.
  double exif_readout_s = 0.03;
  int max_num_iterations = 30;
  // Relative change of the cost at which the solver stops in the last round. Not part of the
  // service's options: evaluations vary it to measure how far a result depends on it.
  double function_tolerance = 1e-4;

  // --- Priors ---
  // Prior deviations of attitudes that were estimated or corrected from matches. Tilt is about the
  // horizontal axes, yaw about the vertical axis. View::attitude_sd_deg applies only to given
  // attitudes.
  double estimated_tilt_sd_deg = 8.0;
  double estimated_yaw_sd_deg = 20.0;

  // --- What counts as a trustworthy block ---
  // Two views are neighbours if they share at least this many landmarks.
  int min_num_shared_landmarks = 8;
  // A connected view shares at least this many landmarks with the other views of its group.
  int min_num_view_observations = 15;
  // Least number of views in a group. The views of a smaller group check each other too little.
  int min_num_connected_views = 3;
  // Least spread of a group's positions, because the positions determine the scale. The spread is
  // their root mean square distance from their mean, in deviations of one position. In a hover,
  // position noise alone gives a spread of 1.7.
  double min_position_spread_sigma = 3.0;
  // Largest deviation of the tilt of a whole group, because tilt appears as slope in the map. If
  // all positions lie on one line, only the attitudes determine the rotation about this line.
  double max_tilt_sd_deg = 4.0;

  // --- Cost ---
  // In flight, the newest views are adjusted with about this many tracks per view: the longest ones
  // in each part of the image. They suffice to place regions. 0: all tracks.
  int num_refinement_tracks = 75;
  // Does not change the result. The solver itself always uses one thread. With more threads, the
  // order of its sums would change from run to run.
  int num_threads = 1;

  void Check() const;
};

// Indices into views, ascending.
std::vector<size_t> SelectKeyframes(const std::vector<View>& views,
                                    const AdjustmentOptions& options);

struct Landmark {
  Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();
  // Standard deviation of its height, metres, computed from ray geometry and pixel noise.
  double height_sd_m = 0.0;
  int num_views = 0;
  int64_t track_id = 0;
};

struct AdjustedView {
  std::string frame_id;
  Rigid3d world_from_camera;
  // Estimated motion of the camera during readout.
  Readout readout;
  double height_above_ground = 0.0;
  // Whether enough observations tie it to other views. If not, the pose is the prior.
  bool is_connected = false;
  // Number of the view's group. Landmarks connect the views of one group. Only the priors relate
  // two groups. Negative if the view is not connected.
  int group = -1;
  // Approximate deviation of the absolute position, along one axis. Its square is the sum of two
  // variances:
  // - the variance of the group's mean position;
  // - the variance of the view's own position with landmarks held fixed.
  // The first variance is estimated in two ways, and the larger estimate is used:
  // - from the deviations of the priors, as a mean of at most four independent fixes, because GPS
  //   errors drift;
  // - from the residuals of the priors, as a mean of at most two independent fixes.
  // Bending of the block is not included.
  double position_sd_m = 0.0;
  // The landmarks that the view sees, as indices into AdjustedBlock::landmarks.
  std::vector<size_t> landmarks;
};

// What the photographs say about one kind of parameter that each view has.
struct ParameterEvidence {
  // "readout.turn^2": the factors of the second power of time in the turns during readout.
  std::string name;
  // Turn by this power at the first and last row, degrees, root mean square over the views.
  double turn_deg = 0.0;
  // Change of Schwarz's criterion (BIC) by these parameters; positive if they pay for themselves.
  double gain = 0.0;
  bool is_kept = false;
};

struct AdjustedBlock {
  // Refined camera, without the readout of a view.
  Camera camera;
  // Same order as the input views.
  std::vector<AdjustedView> views;
  std::vector<Landmark> landmarks;
  double rms_before_px = 0.0;
  double rms_after_px = 0.0;
  // Deviation of the whole block's tilt about its less certain horizontal axis, estimated from the
  // priors. This error adds to every slope. More points do not reduce it.
  double tilt_sd_deg = 0.0;
  // Deviation of the whole block's position, along one axis: the largest of its connected views.
  double position_sd_m = 0.0;
  // If false, all poses are the priors, no view is connected and there are no landmarks.
  bool is_usable = false;
  // The parameters that were tried, in the order of the trials.
  std::vector<ParameterEvidence> evidence;
  // Why the block, or a group of its views, is not usable.
  std::string note;

  // The evidence in words; empty without trials.
  std::string EvidenceNote() const;
  Camera CameraOf(size_t view) const { return camera.With(views[view].readout); }
  // Views of the largest group, ascending.
  std::vector<size_t> LargestGroup() const;
};

// Options for the refinement of the newest views in flight, which only places regions.
AdjustmentOptions InFlight(AdjustmentOptions options);

// Reduces the tracks to about `num_tracks` per view: the longest ones, spread evenly over the
// image. A track that is chosen in one view is kept in all views.
std::vector<View> WithLongestTracks(std::vector<View> views, const Camera& camera, int num_tracks);

// The result is metric and georeferenced, because the priors define position, orientation and
// scale. Throws std::invalid_argument only on empty input. If the solver diverges, is_usable is
// false.
AdjustedBlock AdjustPoses(const std::vector<View>& views,
                          const Camera& camera,
                          const AdjustmentOptions& options);

}  // namespace freelsd
