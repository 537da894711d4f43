#include <cmath>
#include <stdexcept>

#include <doctest/doctest.h>

#include "engine/tracks/tracks.h"

namespace freelsd {
namespace {

TEST_CASE("tracks: options out of range are refused with field, value and constraint") {
  TracksOptions options;
  options.Check();
  options.min_parallax_deg = 0.0;
  CHECK_THROWS_WITH_AS(
      options.Check(), "tracks.min_parallax_deg = 0: must be in [0.1, 60]", std::invalid_argument);
  const auto refuses = [](auto change) {
    TracksOptions changed;
    change(changed);
    CHECK_THROWS_AS(changed.Check(), std::invalid_argument);
  };
  refuses([](TracksOptions& o) { o.max_klt_flow_ratio = std::nan(""); });
  refuses([](TracksOptions& o) { o.max_num_corners = 0; });
  refuses([](TracksOptions& o) { o.max_num_keypoints = -1; });
  refuses([](TracksOptions& o) { o.matching_width_px = 10; });
  refuses([](TracksOptions& o) { o.max_forward_backward_error_px = 0.0; });
  refuses([](TracksOptions& o) { o.min_num_verified_matches = 4; });
  refuses([](TracksOptions& o) { o.max_verification_error_px = 0.0; });
  refuses([](TracksOptions& o) { o.max_num_match_partners = -1; });
  refuses([](TracksOptions& o) { o.num_nearest_tracks = 0; });
  refuses([](TracksOptions& o) { o.max_reprojection_error_px = 0.0; });
  refuses([](TracksOptions& o) { o.max_attitude_disagreement_deg = 0.0; });
  refuses([](TracksOptions& o) { o.nadir_sd_deg = 90.0; });
  refuses([](TracksOptions& o) { o.max_num_waiting_frames = 0; });
  refuses([](TracksOptions& o) { o.ground_matching_width_px = 10; });
  refuses([](TracksOptions& o) { o.max_num_ground_keypoints = 0; });
  refuses([](TracksOptions& o) { o.min_num_tie_matches = 4; });
  refuses([](TracksOptions& o) { o.min_ground_overlap_ratio = -0.1; });
  refuses([](TracksOptions& o) { o.max_ground_error_ratio = 0.0; });
}

}  // namespace
}  // namespace freelsd
