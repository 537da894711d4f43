// Input: views joined by tracks. Output: key-frames, and refined metric poses. Paper: Sec. III-F.
#pragma once

#include <string>
#include <vector>

#include "engine/tracks/tracks.h"

namespace freelsd {

struct AdjustmentOptions {
  // --- Behaviour ---
  // The next key-frame is the predecessor of the first frame that shares fewer tracks with the last
  // key-frame. Paper: 30, Sec. III-F.
  int min_num_track_connections = 30;
  // Paper: "larger than a minimal baseline", no number.
  double min_baseline_m = 8.0;
  // Largest baseline between key-frames, as a share of the height above ground. Differs: with
  // evenly spread corners, the paper's rule alone leaves neighbours with an overlap of an eighth,
  // too little for stereo.
  double max_baseline_ratio = 0.3;
  // Width of the robust loss (Cauchy).
  double robust_loss_px = 1.5;
  // Observations with a larger error after the first solve are dropped before the second.
  double max_reprojection_error_px = 6.0;
  // Refinement of a lens known from EXIF, with prior deviations. Focal length and first radial
  // coefficient are always refined. The second radial and the tangential coefficients and the
  // principal point (share of the focal length) need min_num_lens_views, because fewer views cannot
  // separate them from tilt (decision 0007). Differs: the paper's cameras are calibrated.
  bool refine_exif_intrinsics = true;
  int min_num_lens_views = 20;
  double focal_sd_ratio = 0.05;
  double radial_sd = 0.1;
  double tangential_sd = 0.01;
  double principal_point_sd_ratio = 0.03;
  // Prior deviation of the image's angular rate while a rolling shutter reads it: rotation plus
  // motion past the ground. Differs: the paper's shutters are global. During readout, the image of
  // a survey camera may shift by a hundred pixels. A wider prior lets views that look straight down
  // on flat ground stretch the block.
  double readout_rate_sd_deg_s = 8.0;
  // Prior deviation of the change of that rate during readout: gusts.
  double readout_change_sd_deg_s2 = 400.0;
  // Assumed readout time of a camera known from EXIF alone; 0: global shutter. The estimated motion
  // during readout is kept only if it improves the fit enough for its number of parameters
  // (Schwarz's criterion, BIC). Otherwise it could bend the block.
  double exif_readout_s = 0.03;
  int max_num_iterations = 30;

  // --- Priors ---
  // Deviation of attitudes that were estimated or corrected from matches, about the
  // horizontal axes and about the vertical axis. View::attitude_sd_deg applies only to given
  // attitudes.
  double estimated_tilt_sd_deg = 8.0;
  double estimated_yaw_sd_deg = 20.0;

  // --- What counts as a trustworthy block ---
  // Least number of landmarks that two neighbouring views share.
  int min_num_shared_landmarks = 8;
  // Least number of landmarks that a connected view has in common with other connected views.
  int min_num_view_observations = 15;
  // Least size of a group of connected views: smaller groups have too few mutual checks.
  int min_num_connected_views = 3;
  // Least spread of the positions, which determine the scale: root mean square distance from their
  // mean, in deviations of one position. In a hover, position noise alone gives 1.7.
  double min_position_spread_sigma = 3.0;
  // Largest tilt deviation of a whole group, because tilt becomes slope in the map. If all
  // positions lie on one line, only the attitudes determine the rotation about it.
  double max_tilt_sd_deg = 4.0;

  // --- Cost ---
  // In flight, the newest views are adjusted with about this many tracks per view, the longest in
  // each part of the image. This suffices to place regions. 0: all tracks.
  int num_refinement_tracks = 200;
  // Does not change the result. The solver itself uses one thread, because more would change the
  // order of sums from run to run.
  int num_threads = 1;

  void Check() const;
};

// Indices into views, ascending.
std::vector<size_t> SelectKeyframes(const std::vector<View>& views,
                                    const AdjustmentOptions& options);

struct Landmark {
  Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();
  // Standard deviation of its height from ray geometry and pixel noise, metres.
  double height_sd_m = 0.0;
  int num_views = 0;
};

struct AdjustedView {
  std::string frame_id;
  Rigid3d world_from_camera;
  // Motion during readout, as far as the other views determine it.
  Readout readout;
  double height_above_ground = 0.0;
  // Whether enough observations tie it to other views. If not, the pose is the prior.
  bool is_connected = false;
  // Landmarks tie the connected views of one group to each other. Only priors relate two groups.
  // Negative if the view is not connected.
  int group = -1;
  // Deviation of the absolute position, along one axis; approximate. Adds two variances: that of
  // the group's mean position, and that of the view's own position with landmarks held fixed. The
  // first is the larger of two estimates: from the priors' deviations, as if from at most four
  // independent fixes because GPS drifts; and from the residuals of the priors, as if from at most
  // two. Bending of the block is not included.
  double position_sd_m = 0.0;
  // Landmarks it sees: index into AdjustedBlock::landmarks.
  std::vector<size_t> landmarks;
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
  // priors. It adds to every slope, and more points do not reduce it.
  double tilt_sd_deg = 0.0;
  // Deviation of the whole block's position, along one axis: the largest of its connected views.
  double position_sd_m = 0.0;
  // If false, all poses are the priors, no view is connected and there are no landmarks.
  bool is_usable = false;
  // Why the block, or a group of its views, is not usable.
  std::string note;

  Camera CameraOf(size_t view) const { return camera.With(views[view].readout); }
  // Views of the largest group, ascending.
  std::vector<size_t> LargestGroup() const;
};

// The views with only their longest tracks, about `num_tracks` per view, evenly over the image. A
// track that one view keeps stays complete in all views.
std::vector<View> WithLongestTracks(std::vector<View> views, const Camera& camera, int num_tracks);

// Metric and georeferenced: priors define the gauge. Throws std::invalid_argument on empty input
// only; if the solver diverges, is_usable is false.
AdjustedBlock AdjustPoses(const std::vector<View>& views,
                          const Camera& camera,
                          const AdjustmentOptions& options);

}  // namespace freelsd
