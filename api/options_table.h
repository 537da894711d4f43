// Every field of every Options struct. Stored requests and the evaluation programs read and write
// options by these tables. Names end in their unit. tests/api/options_json_test.cc counts the
// fields, so a missing field fails a test.
#pragma once

#include <concepts>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "engine/pipeline.h"

namespace freelsd {

// Satisfied by `Options` and `const Options`: one VisitFields serves to parse and to print.
template <class T, class Options>
concept Of = std::same_as<std::remove_const_t<T>, Options>;

// Names of an enum's values in JSON.
template <class Enum>
using EnumNames = std::vector<std::pair<Enum, std::string_view>>;

// Without kNone: who wants no preset gives none.
inline EnumNames<Preset> NamesOf(Preset) { return {{Preset::kPaper, "paper"}}; }

inline EnumNames<SegmentationThresholds> NamesOf(SegmentationThresholds) {
  return {{SegmentationThresholds::kGroundSampling, "ground_sampling"},
          {SegmentationThresholds::kPaper, "paper"}};
}

inline EnumNames<GrassFusion> NamesOf(GrassFusion) {
  return {{GrassFusion::kPosterior, "posterior"}, {GrassFusion::kPaperOr, "paper"}};
}

inline EnumNames<SlopeSupport> NamesOf(SlopeSupport) {
  return {{SlopeSupport::kPlane, "plane"}, {SlopeSupport::kPaperPca, "paper"}};
}

// visit(name, field) for every field.
template <class Visitor>
void VisitFields(Of<TracksOptions> auto& o, Visitor&& visit) {
  visit("max_klt_flow_ratio", o.max_klt_flow_ratio);
  visit("max_num_corners", o.max_num_corners);
  visit("max_num_keypoints", o.max_num_keypoints);
  visit("max_num_predicted_corners", o.max_num_predicted_corners);
  visit("matching_width_px", o.matching_width_px);
  visit("max_forward_backward_error_px", o.max_forward_backward_error_px);
  visit("min_num_verified_matches", o.min_num_verified_matches);
  visit("max_verification_error_px", o.max_verification_error_px);
  visit("max_num_match_partners", o.max_num_match_partners);
  visit("num_nearest_tracks", o.num_nearest_tracks);
  visit("min_parallax_deg", o.min_parallax_deg);
  visit("max_reprojection_error_px", o.max_reprojection_error_px);
  visit("max_attitude_disagreement_deg", o.max_attitude_disagreement_deg);
  visit("nadir_sd_deg", o.nadir_sd_deg);
  visit("max_num_waiting_frames", o.max_num_waiting_frames);
  visit("ground_matching_width_px", o.ground_matching_width_px);
  visit("max_num_ground_keypoints", o.max_num_ground_keypoints);
  visit("min_num_tie_matches", o.min_num_tie_matches);
  visit("min_ground_overlap_ratio", o.min_ground_overlap_ratio);
  visit("max_ground_error_ratio", o.max_ground_error_ratio);
  visit("min_tie_overlap_ratio", o.min_tie_overlap_ratio);
  visit("max_num_shared_points", o.max_num_shared_points);
  visit("num_tie_partners", o.num_tie_partners);
  visit("num_tie_points", o.num_tie_points);
  visit("max_alignment_shift_px", o.max_alignment_shift_px);
  visit("min_alignment_correlation", o.min_alignment_correlation);
  visit("assume_ground_plane", o.assume_ground_plane);
}

template <class Visitor>
void VisitFields(Of<SegmentationOptions> auto& o, Visitor&& visit) {
  visit("thresholds", o.thresholds);
  visit("ground_sampling_distance_m", o.ground_sampling_distance_m);
  visit("detail_sampling_distance_m", o.detail_sampling_distance_m);
  visit("blur_sigma_px", o.blur_sigma_px);
  visit("canny_high", o.canny_high);
  visit("chroma_gain", o.chroma_gain);
  visit("split_level_ratio", o.split_level_ratio);
  visit("split_sigma_m", o.split_sigma_m);
  visit("contrast_window_m", o.contrast_window_m);
  visit("reference_grey", o.reference_grey);
  visit("min_grey", o.min_grey);
  visit("max_grey", o.max_grey);
  visit("min_edge_distance_m", o.min_edge_distance_m);
  visit("min_region_area_m2", o.min_region_area_m2);
  visit("paper_canny_coefficients", o.paper_canny_coefficients);
  visit("paper_edge_distance_coefficients", o.paper_edge_distance_coefficients);
  visit("paper_min_height_m", o.paper_min_height_m);
  visit("paper_max_height_m", o.paper_max_height_m);
  visit("paper_focal_px", o.paper_focal_px);
  visit("paper_min_edge_distance_px", o.paper_min_edge_distance_px);
}

template <class Visitor>
void VisitFields(Of<ClassificationOptions> auto& o, Visitor&& visit) {
  visit("min_grass_probability", o.min_grass_probability);
  visit("max_not_grass_probability", o.max_not_grass_probability);
}

template <class Visitor>
void VisitFields(Of<RegionsOptions> auto& o, Visitor&& visit) {
  visit("min_area_m2", o.min_area_m2);
  visit("min_num_observations", o.min_num_observations);
  visit("min_num_observations_floor", o.min_num_observations_floor);
  visit("min_overlap_of_unlike_ratio", o.min_overlap_of_unlike_ratio);
  visit("min_fixing_overlap_ratio", o.min_fixing_overlap_ratio);
  visit("max_num_regions", o.max_num_regions);
  visit("border_margin_px", o.border_margin_px);
  visit("max_viewing_distance_ratio", o.max_viewing_distance_ratio);
}

template <class Visitor>
void VisitFields(Of<WindOptions> auto& o, Visitor&& visit) {
  visit("radius_m", o.radius_m);
  visit("max_age_s", o.max_age_s);
  visit("smoothing", o.smoothing);
}

template <class Visitor>
void VisitFields(Of<AdjustmentOptions> auto& o, Visitor&& visit) {
  visit("min_num_track_connections", o.min_num_track_connections);
  visit("min_baseline_m", o.min_baseline_m);
  visit("max_baseline_ratio", o.max_baseline_ratio);
  visit("robust_loss_px", o.robust_loss_px);
  visit("max_reprojection_error_px", o.max_reprojection_error_px);
  visit("max_reprojection_error_sigma", o.max_reprojection_error_sigma);
  visit("refine_exif_intrinsics", o.refine_exif_intrinsics);
  visit("min_num_lens_views", o.min_num_lens_views);
  visit("focal_sd_ratio", o.focal_sd_ratio);
  visit("radial_sd", o.radial_sd);
  visit("tangential_sd", o.tangential_sd);
  visit("principal_point_sd_ratio", o.principal_point_sd_ratio);
  visit("readout_rate_sd_deg_s", o.readout_rate_sd_deg_s);
  visit("readout_change_sd_deg_s2", o.readout_change_sd_deg_s2);
  visit("max_readout_power", o.max_readout_power);
  visit("exif_readout_s", o.exif_readout_s);
  visit("max_num_iterations", o.max_num_iterations);
  visit("num_refinement_tracks", o.num_refinement_tracks);
  visit("estimated_tilt_sd_deg", o.estimated_tilt_sd_deg);
  visit("estimated_yaw_sd_deg", o.estimated_yaw_sd_deg);
  visit("min_num_shared_landmarks", o.min_num_shared_landmarks);
  visit("min_num_view_observations", o.min_num_view_observations);
  visit("min_num_connected_views", o.min_num_connected_views);
  visit("min_position_spread_sigma", o.min_position_spread_sigma);
  visit("max_tilt_sd_deg", o.max_tilt_sd_deg);
  visit("num_threads", o.num_threads);
}

template <class Visitor>
void VisitFields(Of<StereoOptions> auto& o, Visitor&& visit) {
  visit("ground_sampling_distance_m", o.ground_sampling_distance_m);
  visit("ideal_baseline_ratio", o.ideal_baseline_ratio);
  visit("min_baseline_ratio", o.min_baseline_ratio);
  visit("max_baseline_ratio", o.max_baseline_ratio);
  visit("max_axis_angle_deg", o.max_axis_angle_deg);
  visit("num_partners", o.num_partners);
  visit("num_pairs_per_place", o.num_pairs_per_place);
  visit("min_needed_ratio", o.min_needed_ratio);
  visit("min_num_shared_landmarks", o.min_num_shared_landmarks);
  visit("relief_margin_m", o.relief_margin_m);
  visit("block_size_px", o.block_size_px);
  visit("p1_factor", o.p1_factor);
  visit("p2_factor", o.p2_factor);
  visit("uniqueness_ratio_percent", o.uniqueness_ratio_percent);
  visit("speckle_size_px", o.speckle_size_px);
  visit("max_left_right_difference_px", o.max_left_right_difference_px);
  visit("min_texture_grey", o.min_texture_grey);
  visit("correlation_window_px", o.correlation_window_px);
  visit("min_correlation", o.min_correlation);
  visit("max_num_disparities", o.max_num_disparities);
  visit("max_points_per_m2", o.max_points_per_m2);
  visit("disparity_sd_px", o.disparity_sd_px);
}

template <class Visitor>
void VisitFields(Of<TerrainOptions> auto& o, Visitor&& visit) {
  visit("cell_size_m", o.cell_size_m);
  visit("interpolation_radius_m", o.interpolation_radius_m);
  visit("min_num_points", o.min_num_points);
  visit("outlier_sigma", o.outlier_sigma);
  visit("max_pair_disagreement_m", o.max_pair_disagreement_m);
  visit("pair_agreement_sigma", o.pair_agreement_sigma);
  visit("unchecked_factor", o.unchecked_factor);
  visit("upper_percentile", o.upper_percentile);
  visit("max_relief_m", o.max_relief_m);
  visit("max_num_cells", o.max_num_cells);
}

template <class Visitor>
void VisitFields(Of<PhotoOptions> auto& o, Visitor&& visit) {
  visit("orthophoto_cell_size_m", o.orthophoto_cell_size_m);
  visit("min_crossing_ratio", o.min_crossing_ratio);
  visit("max_photo_disagreement", o.max_photo_disagreement);
  visit("min_open_cover_radius_m", o.min_open_cover_radius_m);
  visit("open_cover_margin_m", o.open_cover_margin_m);
  visit("min_narrow_cover_m", o.min_narrow_cover_m);
  visit("narrow_cover_allowance_m", o.narrow_cover_allowance_m);
  visit("lone_allowance_m", o.lone_allowance_m);
  visit("max_lone_size_m", o.max_lone_size_m);
  visit("lone_surroundings_m", o.lone_surroundings_m);
  visit("min_lone_meadow_ratio", o.min_lone_meadow_ratio);
}

template <class Visitor>
void VisitFields(Of<SurfaceOptions> auto& o, Visitor&& visit) {
  visit("slope_support", o.slope_support);
  visit("plane_support_m", o.plane_support_m);
  visit("min_support_ratio", o.min_support_ratio);
  visit("roughness_spacing_m", o.roughness_spacing_m);
  visit("max_standard_deviation_m", o.max_standard_deviation_m);
}

template <class Visitor>
void VisitFields(Of<CoverOptions> auto& o, Visitor&& visit) {
  visit("grass_fusion", o.grass_fusion);
  visit("min_grass_posterior", o.min_grass_posterior);
  visit("min_observation_probability", o.min_observation_probability);
  visit("max_observation_probability", o.max_observation_probability);
  visit("max_num_independent_views", o.max_num_independent_views);
  visit("kind_smoothing_m", o.kind_smoothing_m);
  visit("min_kind_contrast", o.min_kind_contrast);
  visit("min_vote_ratio", o.min_vote_ratio);
  visit("upper_margin_m", o.upper_margin_m);
  visit("max_telling_sampling_m", o.max_telling_sampling_m);
  visit("min_row_strength", o.min_row_strength);
  visit("min_row_spacing_m", o.min_row_spacing_m);
  visit("max_row_spacing_m", o.max_row_spacing_m);
  visit("max_row_posterior", o.max_row_posterior);
  visit("min_detail_ratio", o.min_detail_ratio);
  visit("max_still_water_posterior", o.max_still_water_posterior);
  visit("max_even_slope_deg", o.max_even_slope_deg);
  visit("max_even_roughness_m", o.max_even_roughness_m);
  visit("min_object_deviations", o.min_object_deviations);
  visit("object_surroundings_m", o.object_surroundings_m);
  visit("min_object_area_m2", o.min_object_area_m2);
  visit("max_surroundings_deviations", o.max_surroundings_deviations);
  visit("min_fence_deviations", o.min_fence_deviations);
  visit("fence_filter_length_m", o.fence_filter_length_m);
  visit("min_post_deviations", o.min_post_deviations);
  visit("min_num_posts", o.min_num_posts);
}

template <class Visitor>
void VisitFields(Of<ClearClassOptions> auto& o, Visitor&& visit) {
  visit("min_clear_class_posterior", o.min_clear_class_posterior);
}

template <class Visitor>
void VisitFields(Of<ApproachOptions> auto& o, Visitor&& visit) {
  visit("min_map_position_sd_m", o.min_map_position_sd_m);
  visit("unclear_height_allowance_m", o.unclear_height_allowance_m);
  visit("bare_ground_radius_m", o.bare_ground_radius_m);
  visit("max_bare_roughness_m", o.max_bare_roughness_m);
  visit("max_height_sd_m", o.max_height_sd_m);
  visit("tilt_sigma", o.tilt_sigma);
  visit("unknown_wind_mps", o.unknown_wind_mps);
  visit("disc_margin_sigma", o.disc_margin_sigma);
  visit("path_margin_sigma", o.path_margin_sigma);
  visit("max_num_candidates", o.max_num_candidates);
  visit("max_num_reserve_candidates", o.max_num_reserve_candidates);
  visit("start_height_ratios", o.start_height_ratios);
  visit("candidate_spacing_m", o.candidate_spacing_m);
  visit("max_crosswind_ratio", o.max_crosswind_ratio);
  visit("heading_step_deg", o.heading_step_deg);
  visit("wind_sigma", o.wind_sigma);
  visit("calm_wind_mps", o.calm_wind_mps);
  visit("path_step_m", o.path_step_m);
  visit("max_num_rejections", o.max_num_rejections);
}

template <class Visitor>
void VisitFields(Of<RiskOptions> auto& o, Visitor&& visit) {
  visit("num_risk_flights", o.num_risk_flights);
  visit("error_length_m", o.error_length_m);
  visit("unmeasured_wind_sd_mps", o.unmeasured_wind_sd_mps);
}

template <class Visitor>
void VisitFields(Of<BackendOptions> auto& o, Visitor&& visit) {
  visit("backend_period_frames", o.backend_period_frames);
  visit("num_backend_candidates", o.num_backend_candidates);
  visit("max_surroundings_m", o.max_surroundings_m);
  visit("max_num_views", o.max_num_views);
  visit("max_group_extent_m", o.max_group_extent_m);
  visit("max_num_map_sites", o.max_num_map_sites);
  visit("map_site_extent_m", o.map_site_extent_m);
}

// A section of the JSON that holds the options of several stages.
template <class... Parts, class Visitor>
void VisitFields(const std::tuple<Parts&...>& section, Visitor&& visit) {
  std::apply([&visit](auto&... part) { (VisitFields(part, visit), ...); }, section);
}

// visit(name, options) for every section, in the order of the pipeline.
template <class Visitor>
void VisitStages(Of<PipelineOptions> auto& o, Visitor&& visit) {
  visit("tracks", o.tracks);
  visit("segmentation", o.segmentation);
  visit("classification", o.classification);
  visit("regions", o.regions);
  visit("wind", o.wind);
  visit("adjustment", o.adjustment);
  visit("stereo", o.stereo);
  const auto terrain = std::tie(o.terrain, o.hazard.cover.photo);
  visit("terrain", terrain);
  const auto hazard = std::tie(o.hazard.surface, o.hazard.cover);
  visit("hazard", hazard);
  const auto approach = std::tie(o.approach, o.approach.risk, o.hazard.cover.clear_class);
  visit("approach", approach);
  visit("backend", o.backend);
}

}  // namespace freelsd
