#include <cmath>

#include <doctest/doctest.h>

#include "engine/tracks/tracks.h"
#include "tests/engine/refusal.h"

namespace freelsd {
namespace {

TEST_CASE("tracks: options out of range are refused with field, value and constraint") {
  CHECK_NOTHROW(TracksOptions().Check());
  CHECK(RefusalOf(&TracksOptions::min_parallax_deg, 0.0) ==
        "tracks.min_parallax_deg = 0: must be in [0.1, 60]");
  CHECK(IsRefused(&TracksOptions::max_klt_flow_ratio, std::nan(""), "max_klt_flow_ratio"));
  CHECK(IsRefused(&TracksOptions::max_num_corners, 0, "max_num_corners"));
  CHECK(IsRefused(&TracksOptions::max_num_keypoints, -1, "max_num_keypoints"));
  CHECK(IsRefused(&TracksOptions::matching_width_px, 10, "matching_width_px"));
  CHECK(IsRefused(
      &TracksOptions::max_forward_backward_error_px, 0.0, "max_forward_backward_error_px"));
  CHECK(IsRefused(&TracksOptions::min_num_verified_matches, 4, "min_num_verified_matches"));
  CHECK(IsRefused(&TracksOptions::max_verification_error_px, 0.0, "max_verification_error_px"));
  CHECK(IsRefused(&TracksOptions::max_num_match_partners, -1, "max_num_match_partners"));
  CHECK(IsRefused(&TracksOptions::num_nearest_tracks, 0, "num_nearest_tracks"));
  CHECK(IsRefused(&TracksOptions::max_reprojection_error_px, 0.0, "max_reprojection_error_px"));
  CHECK(IsRefused(
      &TracksOptions::max_attitude_disagreement_deg, 0.0, "max_attitude_disagreement_deg"));
  CHECK(IsRefused(&TracksOptions::nadir_sd_deg, 90.0, "nadir_sd_deg"));
  CHECK(IsRefused(&TracksOptions::max_num_waiting_frames, 0, "max_num_waiting_frames"));
  CHECK(IsRefused(&TracksOptions::ground_matching_width_px, 10, "ground_matching_width_px"));
  CHECK(IsRefused(&TracksOptions::max_num_ground_keypoints, 0, "max_num_ground_keypoints"));
  CHECK(IsRefused(&TracksOptions::min_num_tie_matches, 4, "min_num_tie_matches"));
  CHECK(IsRefused(&TracksOptions::min_ground_overlap_ratio, -0.1, "min_ground_overlap_ratio"));
  CHECK(IsRefused(&TracksOptions::max_ground_error_ratio, 0.0, "max_ground_error_ratio"));
}

}  // namespace
}  // namespace freelsd
