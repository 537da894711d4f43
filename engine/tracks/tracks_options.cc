
#include "engine/check/check.h"
#include "engine/tracks/tracks.h"

namespace freelsd {
namespace {}  // namespace

void TracksOptions::Check() const {
  const FieldCheck check("tracks");
  check.Inside("max_klt_flow_ratio", max_klt_flow_ratio, 0.0, 1.0);
  check.Inside("max_num_corners", max_num_corners, 30, 10000);
  check.Inside("max_num_keypoints", max_num_keypoints, 50, 20000);
  check.Inside("max_num_predicted_corners", max_num_predicted_corners, 0, 20000);
  check.Inside("matching_width_px", matching_width_px, 160, 8000);
  check.Inside("max_forward_backward_error_px", max_forward_backward_error_px, 0.01, 20.0);
  check.Inside("min_num_verified_matches", min_num_verified_matches, 8, 1000);
  check.Inside("max_verification_error_px", max_verification_error_px, 0.1, 50.0);
  check.Inside("max_num_match_partners", max_num_match_partners, 0, 100);
  check.Inside("num_nearest_tracks", num_nearest_tracks, 3, 1000);
  check.Inside("min_parallax_deg", min_parallax_deg, 0.1, 60.0);
  check.Inside("max_reprojection_error_px", max_reprojection_error_px, 0.1, 200.0);
  check.Inside("max_attitude_disagreement_deg", max_attitude_disagreement_deg, 5.0, 180.0);
  check.Inside("nadir_sd_deg", nadir_sd_deg, 0.5, 30.0);
  check.Inside("ground_matching_width_px", ground_matching_width_px, 160, 8000);
  check.Inside("max_num_ground_keypoints", max_num_ground_keypoints, 50, 20000);
  check.Inside("min_num_tie_matches", min_num_tie_matches, 8, 1000);
  check.Inside("min_tie_overlap_ratio", min_tie_overlap_ratio, 0.0, 1.0);
  check.Inside("max_num_shared_points", max_num_shared_points, 0, 100000);
  check.Inside("num_tie_partners", num_tie_partners, 1, 1000);
  check.Inside("num_tie_points", num_tie_points, 0, 100000);
  check.Inside("min_ground_overlap_ratio", min_ground_overlap_ratio, 0.0, 1.0);
  check.Inside("max_ground_error_ratio", max_ground_error_ratio, 0.001, 1.0);
  check.Inside("max_alignment_shift_px", max_alignment_shift_px, 0.0, 20.0);
  check.Inside("min_alignment_correlation", min_alignment_correlation, 0.0, 1.0);
  check.Inside("max_num_waiting_frames", max_num_waiting_frames, 2, 200);
}

}  // namespace freelsd
