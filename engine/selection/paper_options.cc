// The published form of every stage, as one set of options. Sections are those of the paper.
//
// What stays ours, because the paper has no other form of it or gives no number:
// - sizes and costs of tracking, of the adjustment and of dense matching;
// - the reduction of n_obs,min = 10 (4 Hz) for survey photographs, which show no place ten times;
// - a slope limit that the deviation of the map's tilt lowers, and half the diagonal of a cell
//   beside Delta_TD: distances are measured between the centres of cells;
// - features of photographs at 0.3 m per pixel, at which the model was trained;
// - what is done where the wind is unknown or calm, and verdict and score of a site.
#include "engine/selection/selection.h"

namespace freelsd {
namespace {

// Larger than anything that is compared with it.
constexpr double kNoLimit = 1e6;

// Sec. III-A: tracks connect consecutive frames, and nothing is matched twice.
TracksOptions PaperTracks() {
  TracksOptions options;
  options.max_num_match_partners = 0;
  options.max_num_predicted_corners = 0;
  options.min_ground_overlap_ratio = 1.0;
  options.num_tie_points = 0;
  options.max_alignment_shift_px = 0.0;
  return options;
}

// Sec. III-C: Canny on grey levels, and the polynomials of height.
SegmentationOptions PaperSegmentation() {
  SegmentationOptions options;
  options.thresholds = SegmentationThresholds::kPaper;
  options.blur_sigma_px = 0.0;
  options.chroma_gain = 0.0;
  options.split_sigma_m = 0.0;
  options.contrast_window_m = 0.0;
  options.min_grey = 0.0;
  options.max_grey = 255.0;
  return options;
}

// Sec. III-D: the majority of trees. The share of votes is a multiple of 1 / number of trees, so
// no region is unsure.
ClassificationOptions PaperClassification() {
  ClassificationOptions options;
  options.min_grass_probability = 0.5;
  options.max_not_grass_probability = 0.499;
  return options;
}

// Sec. III-E: one region contains the other's centre; any fully visible segment fixes corners.
RegionsOptions PaperRegions() {
  RegionsOptions options;
  options.min_num_observations = 10;
  options.min_overlap_of_unlike_ratio = 0.0;
  options.min_fixing_overlap_ratio = 0.0;
  options.max_num_regions = 20;
  options.max_viewing_distance_ratio = kNoLimit;
  return options;
}

// Sec. III-F: key-frames by connections alone, calibrated cameras with global shutters, and no
// rule on which blocks to trust.
AdjustmentOptions PaperAdjustment() {
  AdjustmentOptions options;
  options.min_num_track_connections = 30;
  options.max_baseline_ratio = 2.0;
  options.max_reprojection_error_sigma = kNoLimit;
  options.refine_exif_intrinsics = false;
  options.exif_readout_s = 0.0;
  options.min_num_connected_views = 2;
  options.min_position_spread_sigma = 0.0;
  options.max_tilt_sd_deg = 90.0;
  return options;
}

// Sec. III-F: one pair per key-frame, and what semi-global matching finds.
StereoOptions PaperStereo() {
  StereoOptions options;
  options.num_partners = 1;
  options.num_pairs_per_place = 0;
  options.min_texture_grey = 0.0;
  options.min_correlation = 0.0;
  return options;
}

// Sec. III-G: the OR of all masks, and no rule for what looks like grass.
CoverOptions PaperCover() {
  CoverOptions options;
  options.grass_fusion = GrassFusion::kPaperOr;
  options.min_vote_ratio = 0.0;
  options.kind_smoothing_m = 0.0;
  options.min_row_strength = 0.0;
  options.min_detail_ratio = 0.0;
  options.min_object_deviations = 0.0;
  options.min_fence_deviations = 0.0;
  options.max_telling_sampling_m = 10.0;
  options.photo.max_photo_disagreement = 0.0;
  return options;
}

// Sec. III-G: principal components of 3 x 3 cells, and roughness between neighbouring cells.
HazardOptions PaperHazard() {
  HazardOptions options;
  options.surface.slope_support = SlopeSupport::kPaperPca;
  options.surface.roughness_spacing_m = 0.05;  // at least one cell
  options.surface.max_standard_deviation_m = 100.0;
  options.cover = PaperCover();
  return options;
}

// Sec. III-H: Delta_TD alone, from h_app, into the wind; Eq. 1 allows for an error of the wind's
// direction and not of its speed.
ApproachOptions PaperApproach() {
  ApproachOptions options;
  options.min_map_position_sd_m = 0.0;
  options.disc_margin_sigma = 0.0;
  options.path_margin_sigma = 0.0;
  options.unclear_height_allowance_m = 0.0;
  options.max_height_sd_m = 100.0;
  options.tilt_sigma = 0.0;
  options.wind_sigma = 0.0;
  options.start_height_ratios = {1.0};
  options.max_crosswind_ratio = 0.0;
  return options;
}

// Sec. III: N = 150, n = 1, one site per region.
BackendOptions PaperBackend() {
  BackendOptions options;
  options.backend_period_frames = 150;
  options.num_backend_candidates = 1;
  options.max_num_map_sites = 0;
  return options;
}

}  // namespace

PipelineOptions PaperOptions() {
  PipelineOptions options;
  options.preset = Preset::kPaper;
  options.tracks = PaperTracks();
  options.segmentation = PaperSegmentation();
  options.classification = PaperClassification();
  options.regions = PaperRegions();
  options.adjustment = PaperAdjustment();
  options.stereo = PaperStereo();
  options.terrain.height_fusion = HeightFusion::kPaperMean;  // Sec. III-G, IDW
  options.hazard = PaperHazard();
  options.approach = PaperApproach();
  options.backend = PaperBackend();
  return options;
}

Aircraft PaperAircraft(Aircraft aircraft) {
  aircraft.ground_roll_m = 0.0;
  aircraft.max_failure_probability = 1.0;
  return aircraft;
}

}  // namespace freelsd
