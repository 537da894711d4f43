// Input: elevation map, grass observations and photographs. Output: what grows or stands on the
// ground, and where the map's height is not reliable.
#pragma once

#include <vector>

#include "engine/terrain/terrain.h"

namespace freelsd {

enum class GrassFusion { kPosterior, kPaperOr };

// Options of the orthophoto and of the comparison of photographs. In error messages the fields are
// named `terrain.…`.
struct PhotoOptions {
  // Cell size of the orthophoto. A wheel track is two cells wide.
  double orthophoto_cell_size_m = 0.25;
  // Two photographs are compared if the horizontal distance between their cameras is at least this
  // share of the height above ground. Both are projected onto the map. The map's height is wrong
  // where their log brightness deviates by more than max_photo_disagreement. If that is 0, there is
  // no comparison.
  double min_crossing_ratio = 0.2;
  double max_photo_disagreement = 0.06;
  // A disagreement counts only where it, together with unseen ground, contains a disc of this
  // radius. It is then widened by the margin. This keeps tree crowns and ignores the edges of
  // hedges.
  double min_open_cover_radius_m = 2.0;
  double open_cover_margin_m = 1.0;
  // Small crowns cannot be distinguished from edges. Where a disagreement contains no such disc but
  // a square of this side, the allowance is added to the upper height. Saplings may grow in hedges
  // (decision 0014).
  double min_narrow_cover_m = 2.0;
  double narrow_cover_allowance_m = 2.5;
  // A lone object (narrow cover, or an object found in a meadow) may be a leafless sapling, which
  // the map hardly shows. It gets this allowance instead. An object is lone if it is at most
  // max_lone_size_m wide and at least min_lone_meadow_ratio of the cells within lone_surroundings_m
  // around it are meadow.
  double lone_allowance_m = 4.0;
  double max_lone_size_m = 8.0;
  double lone_surroundings_m = 3.0;
  double min_lone_meadow_ratio = 0.8;

  void Check() const;
};

// Defines which cells are certainly neither tree nor crop. In error messages the field is named
// `approach.…`.
struct ClearClassOptions {
  // A cell with at least this posterior of grass has a clear class: its measured height includes
  // everything that stands there.
  double min_clear_class_posterior = 0.5;

  void Check() const;
};

// Rules for ground that looks like a meadow. In error messages the fields are named `hazard.…`.
struct CoverOptions {
  // --- Behaviour ---
  // kPosterior: posterior over all observations of a cell. kPaperOr: the paper's OR of all fine
  // masks.
  GrassFusion grass_fusion = GrassFusion::kPosterior;
  // Greater than max_observation_probability, so that one view never suffices.
  double min_grass_posterior = 0.95;
  // Limits of one observation's probability: no single view is ever certain.
  double min_observation_probability = 0.1;
  double max_observation_probability = 0.9;
  // Errors of views at 4 Hz are not independent (same light, same growth). The mean log-odds of a
  // cell is multiplied by its number of views, but at most by this number. Differs: the paper takes
  // the OR of all masks (Sec. III-G, decision 0003).
  double max_num_independent_views = 4.0;
  // A cell has a class only if at least this share of the views that see it classified it. Nearly
  // every view leaves canopy and rubble unclassified, so they get no class.
  double min_vote_ratio = 0.2;
  // A cell is a hazard if its upper height exceeds its elevation by more than max_roughness_m plus
  // this margin: a pole, bush or animal stands there. The upper height is the highest 95th
  // percentile of several stereo pairs; the margin covers about 2.5 times its noise of 0.2 m.
  double upper_margin_m = 0.5;
  // --- What looks like grass from above, but is not ---
  // Least contrast of a rut: how much less green it is than the plants beside it, as a share of the
  // brightness, averaged over the filter length. 0: no search for tracks, as in the paper.
  double min_rut_contrast = 0.03;
  double rut_filter_length_m = 8.0;
  double min_track_length_m = 15.0;
  // Distance between neighbouring tracks. Sprayers have working widths in this range; mowers have
  // smaller ones.
  double min_working_width_m = 6.0;
  double max_working_width_m = 42.0;
  // Coarsest ground sampling distance at which ruts, rows and fences are visible. Coarser images
  // cause a warning.
  double max_telling_sampling_m = 0.35;
  // Sprayed ground reaches half a working width from a track, plus this margin.
  double sprayed_margin_m = 2.0;
  // Largest difference in colour, in standard deviations, between the sprayed part of a field and
  // the rest of it.
  double max_field_color_deviations = 2.0;
  // Crops in rows: least peak power of the spectrum, relative to the median power at the same
  // spacing, for row spacings in this range. 0: no search.
  double min_row_strength = 10.0;
  double min_row_spacing_m = 0.55;
  double max_row_spacing_m = 0.9;
  // Ground with less fine detail than this, as a share of its brightness, is water with algae. 0:
  // no search.
  double min_detail_ratio = 0.015;
  // A closed crop is as even as a meadow but higher than its surroundings. It has this step in
  // height along at least this length of its border, and along at least this share of the border
  // whose step is known. 0: no search.
  double min_raised_step_m = 0.6;
  double min_raised_border_m = 30.0;
  double min_raised_border_ratio = 0.3;
  // The step at a border is known if two planes of equal slope, one on each side, fit the heights
  // within this residual. A strip of width border_ramp_m is left out, because stereo turns the step
  // into a ramp. Grass counts as even if its slope and roughness are within these limits, which do
  // not depend on the aircraft.
  double max_border_residual_m = 0.25;
  double border_ramp_m = 3.0;
  double max_even_slope_deg = 10.0;
  double max_even_roughness_m = 0.5;
  // Image segments may extend across soft borders into other ground. A grass cell is dropped if its
  // colour is nearer to that of other ground within this distance than to that of grass, and if the
  // two colours differ by this number of deviations. 0: no search.
  double min_overreach_deviations = 2.0;
  double overreach_surroundings_m = 30.0;
  // Boulders, animals, cars: patches of at least this area whose colour or brightness differs from
  // that of the surroundings by this number of deviations. 0: no search.
  double min_object_deviations = 7.0;
  double object_surroundings_m = 10.0;
  double min_object_area_m2 = 0.4;
  // The surroundings are measured again without pixels that deviate by more than this.
  double max_surroundings_deviations = 3.5;
  // Fences: a line of this length must be darker than the ground on both sides by this number of
  // deviations of such lines anywhere. It must contain this number of posts. A post is a cell
  // darker than its surroundings by min_post_deviations, in deviations of single cells. 0: no
  // search.
  double min_fence_deviations = 3.0;
  double fence_filter_length_m = 16.0;
  double min_post_deviations = 4.0;
  int min_num_posts = 4;

  PhotoOptions photo;
  ClearClassOptions clear_class;

  void Check() const;
};

// Fine mask of one view, in image coordinates. It is projected onto the map.
struct GrassView {
  Rigid3d world_from_camera;
  // Camera of the full-size image.
  Camera camera;
  // At working size: 0 = not classified (edges, dark, unsure), else 1 + round(254 * probability).
  cv::Mat1b mask;
  double image_px_per_mask_px = 1.0;
};

// The ground seen from straight above. Each cell is taken from the view that looks down on it most
// steeply.
struct Orthophoto {
  // Aligned with the map: each map cell consists of a whole number of these cells.
  Grid grid;
  cv::Mat3b image;  // BGR, as photographed; black where unseen
  cv::Mat1b seen;   // 255 or 0
  // The same ground from a second view, for comparison: the steepest one whose camera is far enough
  // from the first one's (min_crossing_ratio). Empty if photographs are not compared.
  cv::Mat3b second_image;
  cv::Mat1b second_seen;
  // The views that both images are taken from, one value per map cell: index into the block's
  // views; -1 for none.
  cv::Mat1i view, second_view;
};

// Covers the ground that both the map and a connected view see. `images` returns full-size images;
// a frame whose image is empty is skipped. Empty for an empty map.
Orthophoto MakeOrthophoto(const ElevationMap& map,
                          const AdjustedBlock& block,
                          const ImageSource& images,
                          const PhotoOptions& options);

// Result of comparing photographs. One value per map cell.
struct OpenCover {
  // 255 where photographs disagree, or where two photographs do not show the cell; else 0. The
  // deviation of the height is unknown there.
  cv::Mat1b is_unknown;
  // Metres to add to the map's upper height.
  cv::Mat1f allowance_m;
  // Whether photographs were compared. If not, both rasters are empty.
  bool is_compared = false;
};

struct GroundCover {
  // Posterior probability of grass. NaN where no view, or too small a share of the views,
  // classified the cell. 0 where the orthophoto or the heights show a crop, water, a fence, an
  // object or other ground, whatever the views report.
  cv::Mat1f grass;
  OpenCover open;
};

// With an empty orthophoto the only search is that for raised fields.
GroundCover AssessCover(const ElevationMap& map,
                        const GroundSurface& surface,
                        const std::vector<GrassView>& grass_views,
                        const CoverOptions& options,
                        const Orthophoto& photo = {});

// Applies the cover to the map: the deviation becomes NaN where it is unknown, and the upper height
// includes the allowance.
ElevationMap WithCover(const ElevationMap& map, const OpenCover& cover);

}  // namespace freelsd
