// Input: elevation map, grass observations and photographs. Output: what grows or stands on the
// ground, and where the height of the map cannot be trusted.
#pragma once

#include <vector>

#include "engine/terrain/terrain.h"

namespace freelsd {

enum class GrassFusion { kPosterior, kPaperOr };

// The orthophoto and the comparison of photographs. Messages name its fields `terrain.…`.
struct PhotoOptions {
  // Cell size of the orthophoto. A wheel track is two cells wide.
  double orthophoto_cell_size_m = 0.25;
  // Two photographs are compared if their cameras are at least this share of the height apart; 0:
  // no comparison. They disagree where, projected onto the map, their log brightness deviates by
  // more than max_photo_disagreement: the map's height is wrong there.
  double min_crossing_ratio = 0.2;
  double max_photo_disagreement = 0.06;
  // A disagreement counts only where a disc of this radius fits into it, or into it and unseen
  // ground. It then extends by the margin. This keeps crowns and drops edges of hedges.
  double min_open_cover_radius_m = 2.0;
  double open_cover_margin_m = 1.0;
  // Small crowns look like other edges. Where no disc fits into a disagreement but a square of
  // this side does, the upper height rises by the allowance. Hedges carry saplings (decision
  // 0014).
  double min_narrow_cover_m = 2.0;
  double narrow_cover_allowance_m = 2.5;
  // A lone thing (narrow cover or an object in a meadow) may be a leafless sapling, which the map
  // hardly shows. It gets this allowance instead. Lone: at most this wide, and within its
  // surroundings at least this share of the cells has a clear class.
  double lone_allowance_m = 4.0;
  double max_lone_size_m = 8.0;
  double lone_surroundings_m = 3.0;
  double min_lone_meadow_ratio = 0.8;

  void Check() const;
};

// Which cells are certainly neither tree nor crop. Messages name its field `approach.…`.
struct ClearClassOptions {
  // A cell whose posterior of grass is at least this has a clear class: the map measured what
  // stands there.
  double min_clear_class_posterior = 0.5;

  void Check() const;
};

// The rules for what looks like a meadow. Messages name its fields `hazard.…`.
struct CoverOptions {
  // --- Behaviour ---
  // Posterior over the observations of a cell, or the paper's OR of all fine masks.
  GrassFusion grass_fusion = GrassFusion::kPosterior;
  // Above max_observation_probability, so that one view never suffices.
  double min_grass_posterior = 0.95;
  // Limits of one observation's probability: no single view is ever certain.
  double min_observation_probability = 0.1;
  double max_observation_probability = 0.9;
  // Errors of views at 4 Hz are not independent (same light, same growth). Further views add no
  // certainty: only their mean log-odds counts. Paper: OR of all masks, Sec. III-G. Differs:
  // decision 0003.
  double max_num_independent_views = 4.0;
  // Share of the views of a cell that must have classified it. Below this share the cell has no
  // class, because nearly every view leaves canopy and rubble unclassified.
  double min_vote_ratio = 0.2;
  // A cell is a hazard if its upper height exceeds its elevation by more than max_roughness_m plus
  // this: a pole, bush or animal. The margin covers the noise of the highest of several pairs' 95th
  // percentiles: about 2.5 deviations of 0.2 m.
  double upper_margin_m = 0.5;
  // --- What looks like grass from above, and is not ---
  // Greenness that a rut lacks against the plants beside it, as a share of the brightness, averaged
  // over the filter length. 0: no tracks are searched, as in the paper.
  double min_rut_contrast = 0.03;
  double rut_filter_length_m = 8.0;
  double min_track_length_m = 15.0;
  // Distance between neighbouring tracks. Sprayers are this wide; mowers are narrower.
  double min_working_width_m = 6.0;
  double max_working_width_m = 42.0;
  // Largest ground sampling distance at which ruts, rows and fences are visible. The evaluation
  // warns if images are coarser.
  double max_telling_sampling_m = 0.35;
  // Sprayed ground reaches half a working width from a track, plus this margin.
  double sprayed_margin_m = 2.0;
  // The rest of a field matches the colour of its sprayed part within this many deviations.
  double max_field_color_deviations = 2.0;
  // Crops in rows: strength of the strongest direction in the spectrum, in medians, for rows at
  // these distances. 0: no search.
  double min_row_strength = 10.0;
  double min_row_spacing_m = 0.55;
  double max_row_spacing_m = 0.9;
  // Water with algae has less fine detail than this, as a share of the brightness. 0: no
  // search.
  double min_detail_ratio = 0.015;
  // A closed crop is as even as a meadow but stands above its surroundings: by at least this
  // step, along at least this length of border and this share of the border that is known. 0: no
  // search.
  double min_raised_step_m = 0.6;
  double min_raised_border_m = 30.0;
  double min_raised_border_ratio = 0.3;
  // A border is known where planes of one slope fit both sides within this residual. Stereo turns
  // the step into a ramp, which is left out. Only grass within these limits of slope and roughness
  // counts as even, whatever the aircraft's limits are.
  double max_border_residual_m = 0.25;
  double border_ramp_m = 3.0;
  double max_even_slope_deg = 10.0;
  double max_even_roughness_m = 0.5;
  // Segments reach over soft borders. A grass cell is dropped if its colour is nearer to other
  // ground than to grass, both within this distance, and the two colours differ by this many
  // deviations. 0: no search.
  double min_overreach_deviations = 2.0;
  double overreach_surroundings_m = 30.0;
  // Boulders, animals, cars: patches of at least this area whose colour or brightness differs from
  // the surroundings by this many deviations. 0: no search.
  double min_object_deviations = 7.0;
  double object_surroundings_m = 10.0;
  double min_object_area_m2 = 0.4;
  // Pixels that deviate by more than this are left out when the surroundings are measured again.
  double max_surroundings_deviations = 3.5;
  // Fences: least darkness of a line of this length against both sides, in deviations of lines
  // anywhere. The line must hold this number of posts, each this many deviations of single cells
  // darker than its surroundings. 0: no search.
  double min_fence_deviations = 3.0;
  double fence_filter_length_m = 16.0;
  double min_post_deviations = 4.0;
  int min_num_posts = 4;

  PhotoOptions photo;
  ClearClassOptions clear_class;

  void Check() const;
};

// Fine mask of one view, in image coordinates, for projection into the map.
struct GrassView {
  Rigid3d world_from_camera;
  // Of the full-size image.
  Camera camera;
  // Working size: 0 = not classified (edges, dark, unsure), else 1 + round(254 * probability).
  cv::Mat1b mask;
  double image_px_per_mask_px = 1.0;
};

// The ground from straight above, each cell from the view that looks down on it most steeply.
struct Orthophoto {
  // Aligned with the map it was made with: a map cell is a whole number of these cells.
  Grid grid;
  cv::Mat3b image;  // BGR, as photographed; black where unseen
  cv::Mat1b seen;   // 255 or 0
  // The same from the steepest view elsewhere (min_crossing_ratio); empty if not compared.
  cv::Mat3b second_image;
  cv::Mat1b second_seen;
  // Views of both images, by the map's cells: index into the block's views; -1 for none.
  cv::Mat1i view, second_view;
};

// Covers ground that both the map and a connected view see. `images` returns full-size images; an
// empty one is skipped. Empty for an empty map.
Orthophoto MakeOrthophoto(const ElevationMap& map,
                          const AdjustedBlock& block,
                          const ImageSource& images,
                          const PhotoOptions& options);

// Where photographs disagree about the ground. Cells of the map.
struct OpenCover {
  // 255 where the deviation of the height is unknown, else 0.
  cv::Mat1b is_unknown;
  // Metres to add to the map's upper height.
  cv::Mat1f allowance_m;
  // Whether photographs were compared. If not, both rasters are empty.
  bool is_compared = false;
};

struct GroundCover {
  // Posterior probability of grass; NaN where no view, or too small a share, classified the cell. 0
  // where the orthophoto shows a green crop, water, a fence, an object or the colour of other
  // ground, whatever the views report.
  cv::Mat1f grass;
  OpenCover open;
};

// Without an orthophoto (an empty one) only raised fields are searched.
GroundCover AssessCover(const ElevationMap& map,
                        const GroundSurface& surface,
                        const std::vector<GrassView>& grass_views,
                        const CoverOptions& options,
                        const Orthophoto& photo = {});

// The map with this cover: the deviation is NaN where it is unknown, and the upper height includes
// the allowance.
ElevationMap WithCover(const ElevationMap& map, const OpenCover& cover);

}  // namespace freelsd
