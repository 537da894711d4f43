// Input: views joined by tracks. Output: key-frames, and refined metric poses. Paper: Sec. III-F.
#pragma once

#include <string>
#include <vector>

#include "engine/tracks/tracks.h"

namespace freelsd {

struct AdjustmentOptions {
  // --- Behaviour ---
  // Key-frames: the predecessor of the first frame with fewer connections. Paper: 30, Sec. III-F.
  int min_num_track_connections = 30;
  // Paper: "larger than a minimal baseline", no number.
  double min_baseline_m = 8.0;
  // A key-frame is set at the latest when the baseline reaches this share of the height above
  // ground. Differs: with evenly spread corners the paper's rule alone leaves neighbours that
  // overlap by an eighth, too little for stereo.
  double max_baseline_ratio = 0.3;
  // Width of the robust loss (Cauchy).
  double robust_loss_px = 1.5;
  // Observations farther off than this after the first solve are dropped before the second.
  double max_reprojection_error_px = 6.0;
  // Where the intrinsics come from EXIF, the lens is refined within these deviations: focal length
  // and first radial coefficient always, the second one, the tangential ones and the principal
  // point (as a share of the focal length) from min_num_lens_views views on. Fewer cannot tell
  // them from tilt. Differs: the paper's cameras are calibrated.
  bool refine_exif_intrinsics = true;
  int min_num_lens_views = 20;
  double focal_sd_ratio = 0.05;
  double radial_sd = 0.1;
  double tangential_sd = 0.01;
  double principal_point_sd_ratio = 0.03;
  // How fast the image may slide or turn while a rolling shutter reads it, by rotation and by
  // flight past the ground together: the deviation from no motion. Differs: the paper's shutters
  // are global; a survey photograph may be displaced by a hundred pixels. Wider, and views that all
  // look down on flat ground stretch the block along their own axes.
  double readout_rate_sd_deg_s = 8.0;
  // How fast that changes meanwhile, deviation from not at all: gusts.
  double readout_change_sd_deg_s2 = 400.0;
  // Time of readout that is assumed where the camera is known from EXIF alone; 0: global shutter.
  // Kept only where it explains more than its number of parameters would by chance (Schwarz): else
  // it would bend a block that its photographs do not.
  double exif_readout_s = 0.03;
  int max_num_iterations = 30;

  // --- Priors ---
  // Where the attitude was estimated or corrected from matches: its deviation from that estimate
  // about the horizontal axes and about the vertical one. View::attitude_sd_deg counts only where
  // the attitude was given.
  double estimated_tilt_sd_deg = 8.0;
  double estimated_yaw_sd_deg = 20.0;

  // --- What counts as a trustworthy block ---
  // Two views are neighbours from this number of shared landmarks on; a view is connected by this
  // many sightings of landmarks that other connected views see.
  int min_num_shared_landmarks = 8;
  int min_num_view_observations = 15;
  // Smaller groups of connected views have too little to check one another by.
  int min_num_connected_views = 3;
  // Scale comes from how far the positions are spread: root mean square distance from their mean,
  // in deviations of a position. In a hover it is the noise's own, 1.7.
  double min_position_spread_sigma = 3.0;
  // Largest deviation of the tilt of a group as a whole, for it becomes slope in the map. Positions
  // in one line leave the roll about that line to the attitudes.
  double max_tilt_sd_deg = 4.0;

  // --- Cost ---
  // In flight, the newest views are adjusted with about this many tracks per view, the longest of
  // each part of the image: poses to place regions with need no more. 0: all.
  int num_refinement_tracks = 200;
  // Does not change the result. The solver itself keeps to one thread: more would sum in another
  // order on each run.
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
  // How its image was read, as far as the others tell.
  Readout readout;
  double height_above_ground = 0.0;
  // Whether enough observations tie it to the others; without them the pose is only the prior.
  bool is_connected = false;
  // Connected views of one group are tied to one another by landmarks; two groups only by what the
  // priors say of each. Below zero where the view is not connected.
  int group = -1;
  // Of the absolute position, along one axis; an approximation. What the priors have in common
  // (GPS drifts, so they count as four independent fixes at most; as two if off by what the solved
  // block shows of them, where that says more) and what the view's own sightings leave open with
  // the landmarks held fixed. Bending of the block is not in it.
  double position_sd_m = 0.0;
  // Landmarks it sees: index into AdjustedBlock::landmarks.
  std::vector<size_t> landmarks;
};

struct AdjustedBlock {
  // As refined, without any view's readout.
  Camera camera;
  // Same order as the views that were given.
  std::vector<AdjustedView> views;
  std::vector<Landmark> landmarks;
  double rms_before_px = 0.0;
  double rms_after_px = 0.0;
  // Deviation of the tilt of the whole, about the worse horizontal axis, from the priors: a part of
  // the uncertainty of every slope that no number of points averages out.
  double tilt_sd_deg = 0.0;
  // Of the position of the whole, along one axis: the largest of its connected views.
  double position_sd_m = 0.0;
  // Otherwise all poses are the priors, no view is connected and there are no landmarks.
  bool is_usable = false;
  // Why the block, or a group of its views, is not usable.
  std::string note;

  Camera CameraOf(size_t view) const { return camera.With(views[view].readout); }
  // Views of the group with the most, ascending: what is one block.
  std::vector<size_t> LargestGroup() const;
};

// The views with the longest tracks alone, about `num_tracks` of each view, evenly over the image.
// A track that one view keeps stays whole.
std::vector<View> WithLongestTracks(std::vector<View> views, const Camera& camera, int num_tracks);

// Metric and georeferenced: the gauge comes from the priors. Throws std::invalid_argument on empty
// input only; a solver that diverges gives is_usable = false.
AdjustedBlock AdjustPoses(const std::vector<View>& views,
                          const Camera& camera,
                          const AdjustmentOptions& options);

}  // namespace freelsd
