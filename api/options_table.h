// Every field of every Options struct with its help, once: what is parsed, printed and described
// comes from here. Units are in the names. tests/api/options_json_test.cc counts the fields, so
// that none is forgotten.
#pragma once

#include <concepts>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "engine/pipeline.h"

namespace freelsd {

// `Options` or `const Options`.
template <class T, class Options>
concept Of = std::same_as<std::remove_const_t<T>, Options>;

// Names of an enum's values in JSON.
template <class Enum>
using EnumNames = std::vector<std::pair<Enum, std::string_view>>;

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

// visit(name, field, help) for every field.
template <class Visitor>
void VisitFields(Of<TracksOptions> auto& o, Visitor&& visit) {
  visit("max_klt_flow_ratio",
        o.max_klt_flow_ratio,
        "predicted flow up to which corners are followed");
  visit("max_num_corners", o.max_num_corners, "corners kept per frame by the tracker");
  visit("max_num_keypoints", o.max_num_keypoints, "keypoints per frame of the matcher");
  visit("matching_width_px", o.matching_width_px, "wider images are matched at this width");
  visit("max_forward_backward_error_px", o.max_forward_backward_error_px, "of a tracked corner");
  visit("min_num_verified_matches",
        o.min_num_verified_matches,
        "from which two frames are connected");
  visit("max_verification_error_px", o.max_verification_error_px, "of a match, at matching size");
  visit("max_num_match_partners",
        o.max_num_match_partners,
        "earlier views a photograph is matched with");
  visit("num_nearest_tracks", o.num_nearest_tracks, "landmarks that give the height at a pixel");
  visit("min_parallax_deg", o.min_parallax_deg, "of a landmark that is used");
  visit("max_reprojection_error_px", o.max_reprojection_error_px, "of a landmark that is used");
  visit("max_attitude_disagreement_deg",
        o.max_attitude_disagreement_deg,
        "beyond it a given attitude is replaced");
  visit("nadir_sd_deg", o.nadir_sd_deg, "deviation from straight down without attitude");
  visit("max_num_waiting_frames",
        o.max_num_waiting_frames,
        "frames that may wait for attitude or height");
  visit("ground_matching_width_px",
        o.ground_matching_width_px,
        "width at which photographs are matched as seen from above");
  visit("max_num_ground_keypoints", o.max_num_ground_keypoints, "per photograph seen from above");
  visit("min_num_tie_matches", o.min_num_tie_matches, "that tie two groups of photographs");
  visit("min_ground_overlap_ratio",
        o.min_ground_overlap_ratio,
        "share of the smaller photograph's ground that two have in common to be tied");
  visit("max_ground_error_ratio",
        o.max_ground_error_ratio,
        "how far off ground is looked for when tying groups, share of the height");
  visit("assume_ground_plane",
        o.assume_ground_plane,
        "take the ground as a plane below the aircraft");
}

template <class Visitor>
void VisitFields(Of<SegmentationOptions> auto& o, Visitor&& visit) {
  visit("thresholds", o.thresholds, "fixed ground sampling, or the paper's polynomials of height");
  visit(
      "ground_sampling_distance_m", o.ground_sampling_distance_m, "images are resized to it first");
  visit("detail_sampling_distance_m", o.detail_sampling_distance_m, "and to it for their texture");
  visit("blur_sigma_px", o.blur_sigma_px, "smoothing before the edges");
  visit("canny_high", o.canny_high, "upper edge threshold in grey levels; the lower is a third");
  visit("chroma_gain", o.chroma_gain, "stretch of the colour channels for edges; 0: grey alone");
  visit("split_level_ratio", o.split_level_ratio, "excess green at which regions are split");
  visit("split_sigma_m", o.split_sigma_m, "smoothing of excess green; 0: no split");
  visit("contrast_window_m", o.contrast_window_m, "grey is divided by its mean over it; 0: not");
  visit("reference_grey", o.reference_grey, "grey level that the mean becomes");
  visit("min_grey", o.min_grey, "darker pixels are in no region");
  visit("max_grey", o.max_grey, "brighter pixels are in no region");
  visit("min_edge_distance_m", o.min_edge_distance_m, "of a region's pixels from an edge");
  visit("min_region_area_m2", o.min_region_area_m2, "smaller regions are dropped");
  visit("paper_canny_coefficients", o.paper_canny_coefficients, "p_canny(h), highest power first");
  visit("paper_edge_distance_coefficients",
        o.paper_edge_distance_coefficients,
        "p_dtf(h), highest power first");
  visit("paper_min_height_m", o.paper_min_height_m, "heights are clamped to the fitted range");
  visit("paper_max_height_m", o.paper_max_height_m, "heights are clamped to the fitted range");
  visit("paper_focal_px", o.paper_focal_px, "focal length the polynomials hold for");
  visit("paper_min_edge_distance_px", o.paper_min_edge_distance_px, "floor of p_dtf");
}

template <class Visitor>
void VisitFields(Of<ClassificationOptions> auto& o, Visitor&& visit) {
  visit("min_grass_probability", o.min_grass_probability, "from which a region is grass");
  visit("max_not_grass_probability", o.max_not_grass_probability, "up to which it is not");
  visit("min_mean_grey", o.min_mean_grey, "darker regions are not told, grey levels");
  visit("max_mean_grey", o.max_mean_grey, "brighter regions are not told, grey levels");
}

template <class Visitor>
void VisitFields(Of<RegionsOptions> auto& o, Visitor&& visit) {
  visit("min_area_m2", o.min_area_m2, "from which a region has a grade; default: the aircraft's");
  visit("min_num_observations", o.min_num_observations, "from which a region has a grade");
  visit(
      "min_num_observations_floor", o.min_num_observations_floor, "it is never lowered below this");
  visit("min_overlap_of_unlike_ratio",
        o.min_overlap_of_unlike_ratio,
        "overlap that makes grass and another surface one place");
  visit("min_fixing_overlap_ratio",
        o.min_fixing_overlap_ratio,
        "of a region that one view must show to fix its corners");
  visit("max_num_regions", o.max_num_regions, "regions kept");
  visit(
      "border_margin_px", o.border_margin_px, "a corner nearer to the border is not fully visible");
  visit("max_viewing_distance_ratio",
        o.max_viewing_distance_ratio,
        "corners seen from more heights above ground away are not trusted");
}

template <class Visitor>
void VisitFields(Of<WindOptions> auto& o, Visitor&& visit) {
  visit("radius_m", o.radius_m, "measurements farther away do not belong to a place");
  visit("max_age_s", o.max_age_s, "nor older ones, at the time of the newest image");
  visit("smoothing", o.smoothing, "weight of a new measurement in the moving average");
}

template <class Visitor>
void VisitFields(Of<AdjustmentOptions> auto& o, Visitor&& visit) {
  visit("min_num_track_connections", o.min_num_track_connections, "fewer make a new key-frame");
  visit("min_baseline_m", o.min_baseline_m, "between key-frames");
  visit("max_baseline_ratio",
        o.max_baseline_ratio,
        "baseline over height at which a key-frame is set at the latest");
  visit("robust_loss_px", o.robust_loss_px, "width of the Cauchy loss");
  visit("max_reprojection_error_px",
        o.max_reprojection_error_px,
        "of observations kept after the first solve");
  visit("refine_exif_intrinsics", o.refine_exif_intrinsics, "adjust the lens of an EXIF camera");
  visit("min_num_lens_views",
        o.min_num_lens_views,
        "from which on more than focal length and k1 is adjusted");
  visit("focal_sd_ratio", o.focal_sd_ratio, "deviation of an EXIF focal length");
  visit("radial_sd", o.radial_sd, "deviation of k1 and k2 of an EXIF camera");
  visit("tangential_sd", o.tangential_sd, "deviation of p1 and p2 of an EXIF camera");
  visit("principal_point_sd_ratio",
        o.principal_point_sd_ratio,
        "deviation of an EXIF camera's principal point, share of the focal length");
  visit("readout_rate_sd_deg_s",
        o.readout_rate_sd_deg_s,
        "how fast the image may slide while a rolling shutter reads it");
  visit("readout_change_sd_deg_s2", o.readout_change_sd_deg_s2, "how fast that changes meanwhile");
  visit("exif_readout_s", o.exif_readout_s, "time of readout of an EXIF camera");
  visit("max_num_iterations", o.max_num_iterations, "of the solver");
  visit("num_refinement_tracks",
        o.num_refinement_tracks,
        "per view where the newest are adjusted in flight; 0: all");
  visit("estimated_tilt_sd_deg", o.estimated_tilt_sd_deg, "of an attitude that matches gave");
  visit("estimated_yaw_sd_deg", o.estimated_yaw_sd_deg, "of an attitude that matches gave");
  visit("min_num_shared_landmarks", o.min_num_shared_landmarks, "that make two views neighbours");
  visit("min_num_view_observations", o.min_num_view_observations, "that tie a view to others");
  visit("min_num_connected_views", o.min_num_connected_views, "that make a block");
  visit("min_position_spread_sigma",
        o.min_position_spread_sigma,
        "spread of the positions, in their deviations, that gives scale");
  visit("max_tilt_sd_deg", o.max_tilt_sd_deg, "deviation of the whole block's tilt");
  visit("num_threads", o.num_threads, "does not change the result");
}

template <class Visitor>
void VisitFields(Of<StereoOptions> auto& o, Visitor&& visit) {
  visit("ground_sampling_distance_m",
        o.ground_sampling_distance_m,
        "images are matched at it, or at full size");
  visit("ideal_baseline_ratio", o.ideal_baseline_ratio, "baseline over height a pair should have");
  visit("min_baseline_ratio", o.min_baseline_ratio, "baseline over height of a pair");
  visit("max_baseline_ratio", o.max_baseline_ratio, "baseline over height of a pair");
  visit("max_axis_angle_deg", o.max_axis_angle_deg, "between the optical axes of a pair");
  visit("num_partners", o.num_partners, "pairs per view");
  visit("min_num_shared_landmarks", o.min_num_shared_landmarks, "that two views of a pair see");
  visit("relief_margin_m", o.relief_margin_m, "relief allowed beyond the landmarks'");
  visit("block_size_px", o.block_size_px, "of semi-global matching");
  visit("p1_factor", o.p1_factor, "penalty of a disparity step of one");
  visit("p2_factor", o.p2_factor, "penalty of a larger disparity step");
  visit("uniqueness_ratio_percent", o.uniqueness_ratio_percent, "by which the best match must win");
  visit("speckle_size_px", o.speckle_size_px, "smaller islands of disparity are dropped");
  visit("max_left_right_difference_px", o.max_left_right_difference_px, "of the left-right check");
  visit("min_texture_grey", o.min_texture_grey, "flatter windows have nothing to match");
  visit("correlation_window_px", o.correlation_window_px, "of matched windows");
  visit("min_correlation", o.min_correlation, "of matched windows");
  visit("max_num_disparities", o.max_num_disparities, "searched, a multiple of 16");
  visit("max_points_per_m2", o.max_points_per_m2, "points kept per square metre of ground");
  visit("disparity_sd_px", o.disparity_sd_px, "deviation of a disparity");
}

template <class Visitor>
void VisitFields(Of<TerrainOptions> auto& o, Visitor&& visit) {
  visit("cell_size_m", o.cell_size_m, "of the elevation map");
  visit("interpolation_radius_m", o.interpolation_radius_m, "in which points count for a cell");
  visit("min_num_points", o.min_num_points, "a cell needs to be seen");
  visit("outlier_sigma", o.outlier_sigma, "robust deviations from a cell's median");
  visit(
      "upper_percentile", o.upper_percentile, "of a cell's points: the height that clearance uses");
  visit("max_relief_m", o.max_relief_m, "points farther from the landmarks' heights are wild");
  visit("max_num_cells", o.max_num_cells, "of the largest map that is built");
  visit("orthophoto_cell_size_m", o.orthophoto_cell_size_m, "of the picture from straight above");
  visit("min_crossing_ratio",
        o.min_crossing_ratio,
        "of the height, between cameras whose photographs are compared");
  visit("max_photo_disagreement",
        o.max_photo_disagreement,
        "of two photographs of a place whose height is known; 0: not compared");
  visit("min_open_cover_radius_m",
        o.min_open_cover_radius_m,
        "of a disc that fits into what they disagree about");
  visit("open_cover_margin_m", o.open_cover_margin_m, "around it");
  visit("min_narrow_cover_m", o.min_narrow_cover_m, "narrower cover is chance");
  visit("narrow_cover_allowance_m",
        o.narrow_cover_allowance_m,
        "height on top where photographs disagree over less than such cover");
  visit("lone_allowance_m",
        o.lone_allowance_m,
        "height on top of what stands alone in a meadow: it may be a sapling without leaves");
  visit("max_lone_size_m", o.max_lone_size_m, "wider things do not stand alone");
  visit("lone_surroundings_m", o.lone_surroundings_m, "how far around it must be meadow");
  visit("min_lone_meadow_ratio",
        o.min_lone_meadow_ratio,
        "share of those surroundings that must be meadow");
}

template <class Visitor>
void VisitFields(Of<HazardOptions> auto& o, Visitor&& visit) {
  visit("grass_fusion", o.grass_fusion, "posterior over the observations, or the paper's OR");
  visit("min_grass_posterior", o.min_grass_posterior, "from which a cell is grass");
  visit("min_observation_probability",
        o.min_observation_probability,
        "no single view is ever certain");
  visit("max_observation_probability",
        o.max_observation_probability,
        "no single view is ever certain");
  visit("max_num_independent_views",
        o.max_num_independent_views,
        "views beyond this number add no certainty");
  visit("min_vote_ratio", o.min_vote_ratio, "of the views of a cell that must have classified it");
  visit("slope_support", o.slope_support, "plane fit, or the paper's 3x3 cells");
  visit("plane_support_m", o.plane_support_m, "side of the plane fit");
  visit("min_support_ratio", o.min_support_ratio, "of the support's cells that must be seen");
  visit("roughness_spacing_m", o.roughness_spacing_m, "distance of the 8 neighbours");
  visit("upper_margin_m", o.upper_margin_m, "that noise adds to a cell's upper height");
  visit("max_standard_deviation_m",
        o.max_standard_deviation_m,
        "cells above it are as good as unseen");
  visit("min_rut_contrast", o.min_rut_contrast, "of wheel tracks in crops; 0: not looked for");
  visit("rut_filter_length_m", o.rut_filter_length_m, "over which a rut has that contrast");
  visit("min_track_length_m", o.min_track_length_m, "of straight wheel tracks");
  visit("min_working_width_m", o.min_working_width_m, "between neighbouring tracks of a sprayer");
  visit("max_working_width_m", o.max_working_width_m, "between neighbouring tracks of a sprayer");
  visit("sprayed_margin_m", o.sprayed_margin_m, "of a crop beyond half a working width");
  visit("max_field_color_deviations",
        o.max_field_color_deviations,
        "of the field, within which ground beside what is sprayed has its colour");
  visit("max_telling_sampling_m",
        o.max_telling_sampling_m,
        "ground of a pixel beyond which crops cannot be told: an evaluation warns");
  visit("min_row_strength", o.min_row_strength, "of crops in rows; 0: not looked for");
  visit("min_row_spacing_m", o.min_row_spacing_m, "of crops in rows");
  visit("max_row_spacing_m", o.max_row_spacing_m, "of crops in rows");
  visit("min_detail_ratio", o.min_detail_ratio, "less is water; 0: not looked for");
  visit(
      "max_even_slope_deg", o.max_even_slope_deg, "of a piece of grass that may be a closed crop");
  visit("max_even_roughness_m", o.max_even_roughness_m, "the same");
  visit("border_ramp_m",
        o.border_ramp_m,
        "of a crop's border, left out: stereo makes a ramp of a step");
  visit("max_border_residual_m",
        o.max_border_residual_m,
        "of two planes beside a border, beyond which it tells nothing");
  visit("min_raised_step_m",
        o.min_raised_step_m,
        "how much a closed crop stands above what lies around; 0: not looked for");
  visit("min_raised_border_m", o.min_raised_border_m, "of its border, over which it does");
  visit("min_raised_border_ratio",
        o.min_raised_border_ratio,
        "of its border where both sides are even");
  visit("min_overreach_deviations",
        o.min_overreach_deviations,
        "deviations between grass and the other ground beside it, above which colour decides; "
        "0: not looked for");
  visit("overreach_surroundings_m",
        o.overreach_surroundings_m,
        "how far around a cell either ground's colour is taken");
  visit("min_object_deviations",
        o.min_object_deviations,
        "of its surroundings, by which a thing stands out of a meadow; 0: not looked for");
  visit("object_surroundings_m", o.object_surroundings_m, "side of the square of surroundings");
  visit("min_object_area_m2", o.min_object_area_m2, "smaller ones are no things");
  visit("max_surroundings_deviations",
        o.max_surroundings_deviations,
        "what is farther from the surroundings is none of them");
  visit("min_fence_deviations",
        o.min_fence_deviations,
        "a thin dark line in a meadow, against what is beside it; 0: not looked for");
  visit("fence_filter_length_m", o.fence_filter_length_m, "length of a fence's line");
  visit("min_post_deviations", o.min_post_deviations, "how dark a post is in it");
  visit("min_num_posts", o.min_num_posts, "posts that stand apart on it, at least");
}

template <class Visitor>
void VisitFields(Of<ApproachOptions> auto& o, Visitor&& visit) {
  visit("min_map_position_sd_m",
        o.min_map_position_sd_m,
        "the map's horizontal deviation, kept from hazard too");
  visit("unclear_height_allowance_m",
        o.unclear_height_allowance_m,
        "added to trees and unclear cells under the path");
  visit("min_clear_class_posterior",
        o.min_clear_class_posterior,
        "of grass, below which a cell under the path is unclear");
  visit("bare_ground_radius_m",
        o.bare_ground_radius_m,
        "within which all is seen and even where unclear ground is bare");
  visit("max_bare_roughness_m", o.max_bare_roughness_m, "of such ground");
  visit(
      "max_height_sd_m", o.max_height_sd_m, "cells above it are as good as unseen under the path");
  visit("tilt_sigma", o.tilt_sigma, "deviations of the map's tilt that a path clears too");
  visit("unknown_wind_mps",
        o.unknown_wind_mps,
        "from behind, with which the final must be clear too where no wind is known");
  visit("disc_margin_sigma",
        o.disc_margin_sigma,
        "deviations of the map's position that a touchdown keeps away from hazard");
  visit("path_margin_sigma",
        o.path_margin_sigma,
        "deviations of the map's position by which roll and corridor are wider");
  visit("max_num_candidates", o.max_num_candidates, "touchdown candidates tried per region");
  visit("max_num_reserve_candidates",
        o.max_num_reserve_candidates,
        "more of them, where none of those is good");
  visit("start_height_ratios",
        o.start_height_ratios,
        "heights of the start tried where circles are blocked, in approach heights");
  visit("candidate_spacing_m", o.candidate_spacing_m, "between touchdown candidates");
  visit("max_crosswind_ratio",
        o.max_crosswind_ratio,
        "of the landing airspeed, where no final into the wind is good");
  visit("heading_step_deg",
        o.heading_step_deg,
        "of headings tried where the wind is calm or unknown");
  visit("calm_wind_mps", o.calm_wind_mps, "below it the heading is free");
  visit("path_step_m", o.path_step_m, "along path and circle");
  visit("max_num_rejections", o.max_num_rejections, "kept with a site");
  visit("score_weights",
        o.score_weights,
        "hazard distance, clearance, area, slope, roughness, evidence");
}

template <class Visitor>
void VisitFields(Of<BackendOptions> auto& o, Visitor&& visit) {
  visit("backend_period_frames",
        o.backend_period_frames,
        "every so many frames regions are evaluated");
  visit("num_backend_candidates", o.num_backend_candidates, "regions evaluated then");
  visit("max_surroundings_m", o.max_surroundings_m, "ground mapped around a region, at most");
  visit("max_num_views", o.max_num_views, "key-frames that take part in one evaluation");
  visit("max_group_extent_m", o.max_group_extent_m, "regions farther apart get a map each");
  visit("max_num_further_fields",
        o.max_num_further_fields,
        "within the rectangle of one region, besides its own site");
  visit(
      "further_field_extent_m", o.further_field_extent_m, "of pieces in which they are looked for");
}

// visit(name, options) for every stage, in the order of the pipeline.
template <class Visitor>
void VisitStages(Of<PipelineOptions> auto& o, Visitor&& visit) {
  visit("tracks", o.tracks);
  visit("segmentation", o.segmentation);
  visit("classification", o.classification);
  visit("regions", o.regions);
  visit("wind", o.wind);
  visit("adjustment", o.adjustment);
  visit("stereo", o.stereo);
  visit("terrain", o.terrain);
  visit("hazard", o.hazard);
  visit("approach", o.approach);
  visit("backend", o.backend);
}

}  // namespace freelsd
