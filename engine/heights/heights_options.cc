#include "engine/check/check.h"
#include "engine/heights/heights.h"

namespace freelsd {

void HeightsOptions::Check() const {
  const FieldCheck check("heights");
  check.Inside("search_range_m", search_range_m, 0.5, 30.0);
  check.Inside("min_thing_height_m", min_thing_height_m, 0.1, 5.0);
  check.Inside("max_thing_probability", max_thing_probability, 0.0, 1.0);
  check.Inside("thing_prior_probability", thing_prior_probability, 1e-6, 0.5);
  check.Inside("min_num_thing_neighbours", min_num_thing_neighbours, 1, 9);
  check.Inside("min_mode_gain", min_mode_gain, 0.0, 20.0);
  check.Inside("min_proposed_gain", min_proposed_gain, 0.0, 20.0);
  check.Inside("max_narrow_width_m", max_narrow_width_m, 0.0, 10.0);
  check.Inside("thing_window_m", thing_window_m, 0.1, 10.0);
  check.Inside("proposal_window_m", proposal_window_m, 0.0, 50.0);
  check.Inside("min_num_views", min_num_views, 2, 100);
  check.Inside("min_baseline_ratio", min_baseline_ratio, 0.0, 2.0);
  check.Inside("min_correlation", min_correlation, -1.0, 1.0);
  check.Inside("min_contrast", min_contrast, 0.0, 1.0);
  check.Inside("max_num_views", max_num_views, 2, 100);
  check.Inside("max_off_nadir_ratio", max_off_nadir_ratio, 0.1, 3.0);
  check.Inside("ground_sampling_distance_m", ground_sampling_distance_m, 0.01, 5.0);
  check.Inside("height_step_px", height_step_px, 0.1, 4.0);
}

}  // namespace freelsd
