// Every field of every Options struct with its help text. Parsing, printing and description of
// options all use these tables. Names end in their unit. tests/api/options_json_test.cc counts
// the fields, so a missing field fails a test.
#pragma once

#include <tuple>

#include "api/ground_options_table.h"
#include "api/option_names.h"

namespace freelsd {

// visit(name, field, help) for every field.
template <class Visitor>
void VisitFields(Of<TracksOptions> auto& o, Visitor&& visit) {
  visit("max_klt_flow_ratio",
        o.max_klt_flow_ratio,
        "largest predicted flow at which corners are tracked, share of the image");
  visit("max_num_corners", o.max_num_corners, "largest number of tracked corners per frame");
  visit("max_num_keypoints", o.max_num_keypoints, "largest number of matched keypoints per frame");
  visit("max_num_predicted_corners", o.max_num_predicted_corners, "predicted corners; 0: none");
  visit("matching_width_px",
        o.matching_width_px,
        "wider images are reduced to this width for matching");
  visit("max_forward_backward_error_px",
        o.max_forward_backward_error_px,
        "largest error of a corner tracked forward and back again");
  visit("min_num_verified_matches",
        o.min_num_verified_matches,
        "least number of verified matches that connect two frames");
  visit("max_verification_error_px",
        o.max_verification_error_px,
        "largest error of a verified match, at matching size");
  visit("max_num_match_partners",
        o.max_num_match_partners,
        "number of earlier views a photograph is matched with");
  visit("num_nearest_tracks",
        o.num_nearest_tracks,
        "number of landmarks that give the height at a pixel");
  visit("min_parallax_deg", o.min_parallax_deg, "least parallax of a landmark");
  visit("max_reprojection_error_px",
        o.max_reprojection_error_px,
        "largest reprojection error of a landmark");
  visit("max_attitude_disagreement_deg",
        o.max_attitude_disagreement_deg,
        "a given attitude that differs more from the matches is replaced");
  visit("nadir_sd_deg",
        o.nadir_sd_deg,
        "standard deviation from straight down where the attitude is unknown");
  visit("max_num_waiting_frames",
        o.max_num_waiting_frames,
        "largest number of frames that wait for attitude or height");
  visit("ground_matching_width_px",
        o.ground_matching_width_px,
        "width at which photographs projected to the ground are matched");
  visit("max_num_ground_keypoints",
        o.max_num_ground_keypoints,
        "largest number of keypoints per projected photograph");
  visit("min_num_tie_matches",
        o.min_num_tie_matches,
        "least number of matches that tie two groups of photographs");
  visit("min_ground_overlap_ratio",
        o.min_ground_overlap_ratio,
        "least overlap of two tied photographs, share of the smaller one's ground");
  visit("max_ground_error_ratio",
        o.max_ground_error_ratio,
        "search radius when groups are tied, share of the height");
  visit("max_alignment_shift_px",
        o.max_alignment_shift_px,
        "sightings that the alignment moves farther stay where they are; 0: no alignment");
  visit("min_alignment_correlation",
        o.min_alignment_correlation,
        "least correlation of two aligned patches");
  visit("assume_ground_plane", o.assume_ground_plane, "assume a plane ground below the aircraft");
}

template <class Visitor>
void VisitFields(Of<SegmentationOptions> auto& o, Visitor&& visit) {
  visit("thresholds",
        o.thresholds,
        "thresholds at a fixed ground sampling, or the paper's polynomials of height");
  visit("ground_sampling_distance_m",
        o.ground_sampling_distance_m,
        "images are resized to this sampling first");
  visit("detail_sampling_distance_m",
        o.detail_sampling_distance_m,
        "images are resized to this sampling for texture");
  visit("blur_sigma_px", o.blur_sigma_px, "smoothing before edge detection");
  visit("canny_high",
        o.canny_high,
        "upper edge threshold in grey levels; the lower one is a third of it");
  visit(
      "chroma_gain", o.chroma_gain, "gain of the colour channels in edge detection; 0: grey only");
  visit(
      "split_level_ratio", o.split_level_ratio, "level of excess green at which regions are split");
  visit("split_sigma_m", o.split_sigma_m, "smoothing of excess green; 0: regions are not split");
  visit("contrast_window_m", o.contrast_window_m, "window of local contrast normalisation; 0: off");
  visit("reference_grey", o.reference_grey, "grey level of the local mean after normalisation");
  visit("min_grey", o.min_grey, "darker pixels belong to no region");
  visit("max_grey", o.max_grey, "brighter pixels belong to no region");
  visit("min_edge_distance_m",
        o.min_edge_distance_m,
        "least distance of a region's pixels from an edge");
  visit("min_region_area_m2", o.min_region_area_m2, "smaller regions are dropped");
  visit("paper_canny_coefficients", o.paper_canny_coefficients, "p_canny(h), highest power first");
  visit("paper_edge_distance_coefficients",
        o.paper_edge_distance_coefficients,
        "p_dtf(h), highest power first");
  visit("paper_min_height_m", o.paper_min_height_m, "lower heights are clamped to this one");
  visit("paper_max_height_m", o.paper_max_height_m, "greater heights are clamped to this one");
  visit("paper_focal_px", o.paper_focal_px, "focal length for which the polynomials were fitted");
  visit("paper_min_edge_distance_px", o.paper_min_edge_distance_px, "lower bound of p_dtf");
}

template <class Visitor>
void VisitFields(Of<ClassificationOptions> auto& o, Visitor&& visit) {
  visit("min_grass_probability",
        o.min_grass_probability,
        "least probability of a region classified as grass");
  visit("max_not_grass_probability",
        o.max_not_grass_probability,
        "largest probability of a region classified as not grass");
  visit("min_mean_grey", o.min_mean_grey, "darker regions are not classified, grey levels");
  visit("max_mean_grey", o.max_mean_grey, "brighter regions are not classified, grey levels");
}

template <class Visitor>
void VisitFields(Of<RegionsOptions> auto& o, Visitor&& visit) {
  visit("min_area_m2", o.min_area_m2, "least area of a graded region; default: the aircraft's");
  visit("min_num_observations",
        o.min_num_observations,
        "least number of observations of a graded region");
  visit("min_num_observations_floor",
        o.min_num_observations_floor,
        "lower bound of the reduced min_num_observations");
  visit("min_overlap_of_unlike_ratio",
        o.min_overlap_of_unlike_ratio,
        "least overlap at which grass and another class are the same region");
  visit("min_fixing_overlap_ratio",
        o.min_fixing_overlap_ratio,
        "share of a region that one view must show to fix its corners");
  visit("max_num_regions", o.max_num_regions, "largest number of regions kept");
  visit("border_margin_px",
        o.border_margin_px,
        "a corner nearer to the image border is not fully visible");
  visit("max_viewing_distance_ratio",
        o.max_viewing_distance_ratio,
        "corners seen from farther away are ignored, in heights above ground");
}

template <class Visitor>
void VisitFields(Of<WindOptions> auto& o, Visitor&& visit) {
  visit("radius_m", o.radius_m, "measurements farther from a place are ignored there");
  visit("max_age_s", o.max_age_s, "older measurements are ignored; age at the newest image");
  visit("smoothing", o.smoothing, "weight of a new measurement in the moving average");
}

template <class Visitor>
void VisitFields(Of<AdjustmentOptions> auto& o, Visitor&& visit) {
  visit("min_num_track_connections",
        o.min_num_track_connections,
        "fewer connections start a new key-frame");
  visit("min_baseline_m", o.min_baseline_m, "least baseline between key-frames");
  visit("max_baseline_ratio",
        o.max_baseline_ratio,
        "baseline over height above which a new key-frame always starts");
  visit("robust_loss_px", o.robust_loss_px, "width of the Cauchy loss");
  visit("max_reprojection_error_px",
        o.max_reprojection_error_px,
        "observations with a larger error after the first solve are dropped");
  visit("max_reprojection_error_sigma",
        o.max_reprojection_error_sigma,
        "observations with a larger error are dropped at the end, in deviations of one axis");
  visit("refine_exif_intrinsics",
        o.refine_exif_intrinsics,
        "refine the intrinsics of an EXIF camera");
  visit("min_num_lens_views",
        o.min_num_lens_views,
        "least number of views to refine more than focal length and k1");
  visit("focal_sd_ratio", o.focal_sd_ratio, "relative standard deviation of an EXIF focal length");
  visit("radial_sd", o.radial_sd, "standard deviation of k1 and k2 of an EXIF camera");
  visit("tangential_sd", o.tangential_sd, "standard deviation of p1 and p2 of an EXIF camera");
  visit("principal_point_sd_ratio",
        o.principal_point_sd_ratio,
        "standard deviation of an EXIF principal point, share of the focal length");
  visit("readout_rate_sd_deg_s",
        o.readout_rate_sd_deg_s,
        "standard deviation of the image's rotation rate during readout");
  visit("readout_change_sd_deg_s2",
        o.readout_change_sd_deg_s2,
        "standard deviation of that rate's change");
  visit("max_readout_power",
        o.max_readout_power,
        "highest power of time that is tried in the turn during readout");
  visit("exif_readout_s", o.exif_readout_s, "readout time of an EXIF camera");
  visit("max_num_iterations", o.max_num_iterations, "largest number of solver iterations");
  visit("num_refinement_tracks",
        o.num_refinement_tracks,
        "tracks per view when the newest views are adjusted in flight; 0: all");
  visit("estimated_tilt_sd_deg",
        o.estimated_tilt_sd_deg,
        "standard deviation of a tilt estimated from matches");
  visit("estimated_yaw_sd_deg",
        o.estimated_yaw_sd_deg,
        "standard deviation of a yaw estimated from matches");
  visit("min_num_shared_landmarks",
        o.min_num_shared_landmarks,
        "least number of landmarks that two neighbouring views share");
  visit("min_num_view_observations",
        o.min_num_view_observations,
        "least number of observations that tie a view to others");
  visit("min_num_connected_views", o.min_num_connected_views, "least number of views in a block");
  visit("min_position_spread_sigma",
        o.min_position_spread_sigma,
        "least spread of the positions that gives scale, in standard deviations");
  visit("max_tilt_sd_deg", o.max_tilt_sd_deg, "largest standard deviation of the block's tilt");
  visit("num_threads", o.num_threads, "number of threads; does not change the result");
}

template <class Visitor>
void VisitFields(Of<StereoOptions> auto& o, Visitor&& visit) {
  visit("ground_sampling_distance_m",
        o.ground_sampling_distance_m,
        "images are matched at this sampling, or at full size if that is coarser");
  visit("ideal_baseline_ratio", o.ideal_baseline_ratio, "preferred baseline over height of a pair");
  visit("min_baseline_ratio", o.min_baseline_ratio, "least baseline over height of a pair");
  visit("max_baseline_ratio", o.max_baseline_ratio, "largest baseline over height of a pair");
  visit("max_axis_angle_deg",
        o.max_axis_angle_deg,
        "largest angle between the optical axes of a pair");
  visit("num_partners", o.num_partners, "number of pairs per view");
  visit("min_num_shared_landmarks",
        o.min_num_shared_landmarks,
        "least number of landmarks that both views of a pair see");
  visit("relief_margin_m", o.relief_margin_m, "relief allowed above and below the landmarks");
  visit("block_size_px", o.block_size_px, "block size of semi-global matching");
  visit("p1_factor", o.p1_factor, "penalty of a disparity step of one");
  visit("p2_factor", o.p2_factor, "penalty of a larger disparity step");
  visit("uniqueness_ratio_percent",
        o.uniqueness_ratio_percent,
        "margin by which the best match must win");
  visit("speckle_size_px", o.speckle_size_px, "smaller islands of disparity are dropped");
  visit("max_left_right_difference_px",
        o.max_left_right_difference_px,
        "largest difference in the left-right check");
  visit("min_texture_grey", o.min_texture_grey, "windows with less texture are not matched");
  visit(
      "correlation_window_px", o.correlation_window_px, "side of the windows that are correlated");
  visit("min_correlation", o.min_correlation, "least correlation of matched windows");
  visit("max_num_disparities",
        o.max_num_disparities,
        "largest number of disparities searched, a multiple of 16");
  visit("max_points_per_m2",
        o.max_points_per_m2,
        "largest number of points per square metre of ground");
  visit("disparity_sd_px", o.disparity_sd_px, "standard deviation of a disparity");
}

template <class Visitor>
void VisitFields(Of<ApproachOptions> auto& o, Visitor&& visit) {
  visit("min_map_position_sd_m",
        o.min_map_position_sd_m,
        "least horizontal standard deviation assumed for the map");
  visit("unclear_height_allowance_m",
        o.unclear_height_allowance_m,
        "height added to cells under the path without a clear class");
  visit("bare_ground_radius_m",
        o.bare_ground_radius_m,
        "unclear ground is bare if all ground within this radius is seen and even");
  visit("max_bare_roughness_m", o.max_bare_roughness_m, "largest roughness of bare ground");
  visit("max_height_sd_m",
        o.max_height_sd_m,
        "cells with a larger standard deviation count as unseen under the path");
  visit(
      "tilt_sigma", o.tilt_sigma, "standard deviations of the map's tilt that the path must clear");
  visit("unknown_wind_mps",
        o.unknown_wind_mps,
        "tailwind that the final must allow where the wind is unknown");
  visit("disc_margin_sigma",
        o.disc_margin_sigma,
        "standard deviations of the map's position kept between touchdown and hazard");
  visit("path_margin_sigma",
        o.path_margin_sigma,
        "standard deviations of the map's position that widen roll and corridor");
  visit("max_num_candidates",
        o.max_num_candidates,
        "largest number of touchdown candidates tried per region");
  visit("max_num_reserve_candidates",
        o.max_num_reserve_candidates,
        "further candidates tried where no candidate is good");
  visit("start_height_ratios",
        o.start_height_ratios,
        "start heights tried where circles are blocked, in approach heights");
  visit("candidate_spacing_m", o.candidate_spacing_m, "distance between touchdown candidates");
  visit("max_crosswind_ratio",
        o.max_crosswind_ratio,
        "largest crosswind where no final into the wind is good, share of the landing airspeed");
  visit("heading_step_deg",
        o.heading_step_deg,
        "step of the headings tried in crosswind, in calm and in unknown wind");
  visit("wind_sigma", o.wind_sigma, "standard deviations of the measured wind to allow for");
  visit("calm_wind_mps", o.calm_wind_mps, "in weaker wind every heading is allowed");
  visit("path_step_m", o.path_step_m, "sampling step along path and circle");
  visit("max_num_rejections",
        o.max_num_rejections,
        "largest number of rejections stored with a site");
}

template <class Visitor>
void VisitFields(Of<RiskOptions> auto& o, Visitor&& visit) {
  visit("num_risk_flights", o.num_risk_flights, "flights that the risk is averaged over");
  visit("error_length_m",
        o.error_length_m,
        "errors of the map within this distance along the path count once in the risk");
  visit("unmeasured_wind_sd_mps",
        o.unmeasured_wind_sd_mps,
        "standard deviation of a wind that was not measured, in the risk");
}

template <class Visitor>
void VisitFields(Of<BackendOptions> auto& o, Visitor&& visit) {
  visit("backend_period_frames",
        o.backend_period_frames,
        "number of frames between two evaluations of regions");
  visit("num_backend_candidates",
        o.num_backend_candidates,
        "number of regions in one such evaluation");
  visit("max_surroundings_m", o.max_surroundings_m, "largest distance mapped around a region");
  visit("max_num_views", o.max_num_views, "largest number of key-frames in one evaluation");
  visit("max_group_extent_m", o.max_group_extent_m, "regions farther apart get separate maps");
  visit("max_num_map_sites",
        o.max_num_map_sites,
        "largest number of sites of one map, besides those of the regions");
  visit("map_site_extent_m",
        o.map_site_extent_m,
        "side of the squares of ground that get at most one such site");
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
  visit("heights", o.heights);
  const auto hazard = std::tie(o.hazard.surface, o.hazard.cover);
  visit("hazard", hazard);
  const auto approach = std::tie(o.approach, o.approach.risk, o.hazard.cover.clear_class);
  visit("approach", approach);
  visit("backend", o.backend);
}

}  // namespace freelsd
