#include "engine/check/check.h"
#include "engine/watch/watch.h"

namespace freelsd {

void WatchOptions::Check() const {
  const FieldCheck check("watch");
  check.Inside("min_pixel_m", min_pixel_m, 0.01, 10.0);
  check.Inside("max_sampling_m", max_sampling_m, 0.01, 10.0);
  check.Inside("context_m", context_m, 0.0, 100.0);
  check.Inside("hidden_height_m", hidden_height_m, 0.0, 100.0);
  check.Inside("min_compared_ratio", min_compared_ratio, 0.0, 1.0);
  check.Inside("max_offset_m", max_offset_m, 0.5, 50.0);
  check.Inside("max_turn_deg", max_turn_deg, 0.0, 30.0);
  check.Inside("max_scale_error_ratio", max_scale_error_ratio, 0.0, 0.1);
  check.Inside("block_m", block_m, 1.0, 50.0);
  check.Inside("min_num_matches", min_num_matches, 3.0, 1000.0);
  check.Inside("min_match_ratio", min_match_ratio, 0.0, 1.0);
  check.Inside("min_match_correlation", min_match_correlation, 0.0, 1.0);
  check.Inside("max_match_error_m", max_match_error_m, 0.01, 10.0);
  check.Inside("tolerance_m", tolerance_m, 0.0, 5.0);
  check.Inside("light_window_m", light_window_m, 1.0, 100.0);
  check.Inside("detail_window_m", detail_window_m, 1.0, 100.0);
  check.Inside("noise_grey", noise_grey, 0.1, 50.0);
  check.Inside("grow_deviations", grow_deviations, 0.5, 50.0);
  check.Inside("min_isolation_ratio", min_isolation_ratio, 0.0, 1.0);
  check.Inside("min_own_contrast_ratio", min_own_contrast_ratio, 0.0, 1.0);
  check.Inside("min_evidence", min_evidence, -100.0, 100.0);
  check.Inside("min_area_m2", min_area_m2, 0.0, 100.0);
  check.Inside("max_size_m", max_size_m, 0.5, 100.0);
  check.Inside("max_wait_s", max_wait_s, 0.1, 600.0);
  check.Inside("max_speed_mps", max_speed_mps, 0.0, 100.0);
  check.Inside("place_error_m", place_error_m, 0.1, 50.0);
  check.Inside("min_pair_evidence", min_pair_evidence, -100.0, 100.0);
}

}  // namespace freelsd
