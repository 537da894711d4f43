// Every field of the terrain, cover and hazard options with its help; see options_table.h.
#pragma once

#include "api/option_names.h"

namespace freelsd {

template <class Visitor>
void VisitFields(Of<TerrainOptions> auto& o, Visitor&& visit) {
  visit("cell_size_m", o.cell_size_m, "cell size of the elevation map");
  visit("interpolation_radius_m",
        o.interpolation_radius_m,
        "radius within which points count for a cell");
  visit("min_num_points", o.min_num_points, "least number of points in a seen cell");
  visit("outlier_sigma",
        o.outlier_sigma,
        "points farther from a cell's median are outliers, in robust standard deviations");
  visit("upper_percentile",
        o.upper_percentile,
        "percentile of a cell's points that clearance uses as its height");
  visit("max_relief_m", o.max_relief_m, "points farther from the landmarks' heights are dropped");
  visit("max_num_cells", o.max_num_cells, "largest number of cells in a map");
}

template <class Visitor>
void VisitFields(Of<HeightsOptions> auto& o, Visitor&& visit) {
  visit("method", o.method, "heights by pairs of photographs, or by all photographs");
  visit("search_range_m", o.search_range_m, "heights are searched up and down to this distance");
  visit("min_thing_height_m", o.min_thing_height_m, "higher things stand on the ground");
  visit("thing_prior_probability",
        o.thing_prior_probability,
        "share of open cells on which something stands that the ground's height does not show");
  visit("min_num_thing_neighbours",
        o.min_num_thing_neighbours,
        "a cell with at least this many neighbours with things is unknown");
  visit("min_mode_gain", o.min_mode_gain, "least gain of a height that stands out");
  visit("min_proposed_gain",
        o.min_proposed_gain,
        "the same where pairs of photographs propose the height");
  visit("max_thing_probability",
        o.max_thing_probability,
        "cells with a larger probability of an unseen thing are unknown");
  visit("max_narrow_width_m",
        o.max_narrow_width_m,
        "ground with a wider peak of correlation is compared in wider windows");
  visit("thing_window_m", o.thing_window_m, "side of the squares compared for things");
  visit("proposal_window_m",
        o.proposal_window_m,
        "narrower things do not lift the surface from which heights are searched");
  visit("min_num_views", o.min_num_views, "least number of views of a cell");
  visit("min_baseline_ratio", o.min_baseline_ratio, "least baseline over height of these views");
  visit("min_correlation", o.min_correlation, "least correlation of the views");
  visit("min_contrast", o.min_contrast, "least contrast of the ground, of log brightness");
  visit("max_num_views", o.max_num_views, "largest number of views compared");
  visit("max_off_nadir_ratio",
        o.max_off_nadir_ratio,
        "largest horizontal distance of a compared view, in heights above ground");
  visit("ground_sampling_distance_m",
        o.ground_sampling_distance_m,
        "photographs are compared at this sampling");
  visit("height_step_px", o.height_step_px, "spacing of heights, as a disparity in samples");
}

template <class Visitor>
void VisitFields(Of<PhotoOptions> auto& o, Visitor&& visit) {
  visit("orthophoto_cell_size_m", o.orthophoto_cell_size_m, "cell size of the orthophoto");
  visit("min_crossing_ratio",
        o.min_crossing_ratio,
        "least baseline over height of two compared photographs");
  visit("max_photo_disagreement",
        o.max_photo_disagreement,
        "largest disagreement of two photographs at a known height; 0: off");
  visit("min_open_cover_radius_m",
        o.min_open_cover_radius_m,
        "radius of the smallest disc of disagreement that counts as open cover");
  visit("open_cover_margin_m", o.open_cover_margin_m, "margin around open cover");
  visit("min_narrow_cover_m", o.min_narrow_cover_m, "narrower disagreement is ignored");
  visit("narrow_cover_allowance_m",
        o.narrow_cover_allowance_m,
        "height added where photographs disagree over a narrow area");
  visit("lone_allowance_m",
        o.lone_allowance_m,
        "height added to a lone object in a meadow: it may be a sapling without leaves");
  visit("max_lone_size_m", o.max_lone_size_m, "largest size of a lone object");
  visit("lone_surroundings_m", o.lone_surroundings_m, "width of the surroundings of a lone object");
  visit("min_lone_meadow_ratio",
        o.min_lone_meadow_ratio,
        "least share of meadow in those surroundings");
}

template <class Visitor>
void VisitFields(Of<SurfaceOptions> auto& o, Visitor&& visit) {
  visit("slope_support", o.slope_support, "plane fit, or the paper's 3x3 cells");
  visit("plane_support_m", o.plane_support_m, "side of the plane fit");
  visit("min_support_ratio", o.min_support_ratio, "least share of seen cells in the support");
  visit("roughness_spacing_m", o.roughness_spacing_m, "distance of the 8 neighbours");
  visit("max_standard_deviation_m",
        o.max_standard_deviation_m,
        "cells with a larger standard deviation count as unseen");
}

template <class Visitor>
void VisitCropFields(Of<CoverOptions> auto& o, Visitor&& visit) {
  visit("min_rut_contrast",
        o.min_rut_contrast,
        "least contrast of wheel tracks in crops; 0: not detected");
  visit("rut_filter_length_m",
        o.rut_filter_length_m,
        "length over which the contrast of a rut is measured");
  visit("min_track_length_m", o.min_track_length_m, "least length of straight wheel tracks");
  visit("min_working_width_m",
        o.min_working_width_m,
        "least distance between neighbouring tracks of a sprayer");
  visit("max_working_width_m",
        o.max_working_width_m,
        "largest distance between neighbouring tracks of a sprayer");
  visit("sprayed_margin_m", o.sprayed_margin_m, "margin of a crop beyond half a working width");
  visit("max_field_color_deviations",
        o.max_field_color_deviations,
        "largest colour difference of one field, in standard deviations");
  visit("max_telling_sampling_m",
        o.max_telling_sampling_m,
        "coarsest sampling that shows crops; coarser images cause a warning");
  visit("min_row_strength", o.min_row_strength, "least strength of crop rows; 0: not detected");
  visit("min_row_spacing_m", o.min_row_spacing_m, "least spacing of crop rows");
  visit("max_row_spacing_m", o.max_row_spacing_m, "largest spacing of crop rows");
  visit(
      "min_detail_ratio", o.min_detail_ratio, "ground with less detail is water; 0: not detected");
  visit("max_even_slope_deg",
        o.max_even_slope_deg,
        "largest slope of even grass, on which fences are searched for");
  visit("max_even_roughness_m", o.max_even_roughness_m, "largest roughness of even grass");
}

template <class Visitor>
void VisitObjectFields(Of<CoverOptions> auto& o, Visitor&& visit) {
  visit("min_overreach_deviations",
        o.min_overreach_deviations,
        "colour difference of grass and the ground beside it, in standard deviations, above which "
        "colour decides; 0: off");
  visit("overreach_surroundings_m",
        o.overreach_surroundings_m,
        "radius within which both colours are measured");
  visit("min_object_deviations",
        o.min_object_deviations,
        "least contrast of an object in a meadow, in standard deviations; 0: not detected");
  visit("object_surroundings_m", o.object_surroundings_m, "side of the square of surroundings");
  visit("min_object_area_m2", o.min_object_area_m2, "smaller objects are ignored");
  visit("max_surroundings_deviations",
        o.max_surroundings_deviations,
        "cells that differ more are not part of the surroundings");
  visit("min_fence_deviations",
        o.min_fence_deviations,
        "least contrast of a fence, a thin dark line in a meadow; 0: not detected");
  visit("fence_filter_length_m", o.fence_filter_length_m, "length of a fence's line");
  visit("min_post_deviations", o.min_post_deviations, "least contrast of a fence post");
  visit("min_num_posts", o.min_num_posts, "least number of separate posts in a fence");
}

template <class Visitor>
void VisitFields(Of<CoverOptions> auto& o, Visitor&& visit) {
  visit("cover_method", o.cover_method, "rules with a veto each, or one model of all cues");
  visit("grass_fusion", o.grass_fusion, "posterior over the observations, or the paper's OR");
  visit("min_grass_posterior", o.min_grass_posterior, "least posterior of a grass cell");
  visit("min_observation_probability",
        o.min_observation_probability,
        "lower bound of a single view's probability");
  visit("max_observation_probability",
        o.max_observation_probability,
        "upper bound of a single view's probability");
  visit("max_num_independent_views",
        o.max_num_independent_views,
        "largest number of views that count as independent");
  visit("min_vote_ratio", o.min_vote_ratio, "least share of a cell's views that classified it");
  visit("upper_margin_m", o.upper_margin_m, "margin for noise in a cell's upper height");
  VisitCropFields(o, visit);
  VisitObjectFields(o, visit);
}

template <class Visitor>
void VisitFields(Of<ClearClassOptions> auto& o, Visitor&& visit) {
  visit("min_clear_class_posterior",
        o.min_clear_class_posterior,
        "a cell under the path with a lower grass posterior is unclear");
}

}  // namespace freelsd
