#include "engine/check/check.h"
#include "engine/cover/cover.h"

namespace freelsd {

void PhotoOptions::Check() const {
  const FieldCheck check("terrain");
  check.Inside("orthophoto_cell_size_m", orthophoto_cell_size_m, 0.1, 0.4);
  check.Inside("min_crossing_ratio", min_crossing_ratio, 0.01, 2.0);
  check.Inside("max_photo_disagreement", max_photo_disagreement, 0.0, 10.0);
  check.Inside("min_open_cover_radius_m", min_open_cover_radius_m, 0.0, 20.0);
  check.Inside("open_cover_margin_m", open_cover_margin_m, 0.0, 20.0);
  check.Inside("min_narrow_cover_m", min_narrow_cover_m, 0.0, 20.0);
  check.Inside("narrow_cover_allowance_m", narrow_cover_allowance_m, 0.0, 100.0);
  check.Inside("lone_allowance_m", lone_allowance_m, 0.0, 100.0);
  check.Inside("max_lone_size_m", max_lone_size_m, 0.0, 50.0);
  check.Inside("lone_surroundings_m", lone_surroundings_m, 0.0, 50.0);
  check.Inside("min_lone_meadow_ratio", min_lone_meadow_ratio, 0.0, 1.0);
}

void ClearClassOptions::Check() const {
  const FieldCheck check("approach");
  check.Inside("min_clear_class_posterior", min_clear_class_posterior, 0.0, 1.0);
}

void CoverOptions::Check() const {
  const FieldCheck check("hazard");
  check.Inside("min_grass_posterior", min_grass_posterior, 0.5, 1.0);
  check.Inside("min_observation_probability", min_observation_probability, 0.001, 0.499);
  check.Inside("max_observation_probability", max_observation_probability, 0.501, 0.999);
  check.Inside("max_num_independent_views", max_num_independent_views, 1.0, 1000.0);
  check.Inside("kind_smoothing_m", kind_smoothing_m, 0.0, 100.0);
  check.Inside("min_kind_contrast", min_kind_contrast, 1e-3, 1.0);
  check.Inside("min_vote_ratio", min_vote_ratio, 0.0, 1.0);
  check.Inside("upper_margin_m", upper_margin_m, 0.0, 10.0);
  check.Inside("max_telling_sampling_m", max_telling_sampling_m, 0.01, 10.0);
  check.Inside("min_row_strength", min_row_strength, 0.0, 1e6);
  check.Inside("max_row_spacing_m", max_row_spacing_m, 0.1, 10.0);
  check.Inside("min_row_spacing_m", min_row_spacing_m, 0.1, max_row_spacing_m);
  check.Inside("max_row_posterior", max_row_posterior, 0.0, 1.0);
  check.Inside("min_detail_ratio", min_detail_ratio, 0.0, 1.0);
  check.Inside("max_still_water_posterior", max_still_water_posterior, 0.0, 1.0);
  check.Inside("max_even_slope_deg", max_even_slope_deg, 0.0, 90.0);
  check.Inside("max_even_roughness_m", max_even_roughness_m, 0.0, 1000.0);
  check.Inside("min_object_deviations", min_object_deviations, 0.0, 1000.0);
  check.Inside("object_surroundings_m", object_surroundings_m, 1.0, 40.0);
  check.Inside("min_object_area_m2", min_object_area_m2, 0.0, 1000.0);
  check.Inside("max_surroundings_deviations", max_surroundings_deviations, 0.5, 1000.0);
  check.Inside("min_fence_deviations", min_fence_deviations, 0.0, 1000.0);
  check.Inside("fence_filter_length_m", fence_filter_length_m, 4.0, 100.0);
  check.Inside("min_post_deviations", min_post_deviations, 0.0, 1000.0);
  check.Inside("min_num_posts", min_num_posts, 0, 100);
  photo.Check();
  clear_class.Check();
}

}  // namespace freelsd
