// Input: elevation map, grass observations and photographs. Output: what grows or stands on the
// ground, and where the map's height is not reliable.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/ground_kind/ground_kind.h"
#include "engine/terrain/terrain.h"

namespace freelsd {

enum class GrassFusion { kPosterior, kPaperOr };

// Options of the orthophoto and of the comparison of photographs. In error messages the fields are
// named `terrain.…`.
struct PhotoOptions {
  // Cell size of the orthophoto. A wheel track is two cells wide.
  double orthophoto_cell_size_m = 0.25;
  // Two photographs are compared if the horizontal distance between their cameras is at least
  // min_crossing_ratio times the height above ground. Both are projected onto the map. Where their
  // log brightness differs by more than max_photo_disagreement, the map's height is wrong.
  // max_photo_disagreement = 0: no comparison.
  double min_crossing_ratio = 0.2;
  double max_photo_disagreement = 0.06;
  // Cells where the photographs disagree are joined with neighbouring cells that fewer than two
  // photographs show. Disagreement counts only where a disc of radius min_open_cover_radius_m fits
  // into the joined area. The cells that count are then widened by open_cover_margin_m. Tree crowns
  // are large enough to count; the edges of hedges are not.
  double min_open_cover_radius_m = 2.0;
  double open_cover_margin_m = 1.0;
  // Narrow cover is disagreement where no such disc fits, but a square of side min_narrow_cover_m
  // fits. Narrow cover is a small crown or an edge, and the two cannot be distinguished.
  // narrow_cover_allowance_m is added to its upper height. Saplings may grow in hedges (decision
  // 0014).
  double min_narrow_cover_m = 2.0;
  double narrow_cover_allowance_m = 2.5;
  // A lone object may be a leafless sapling, which the map hardly shows. It gets lone_allowance_m
  // instead. Narrow cover, or an object found in a meadow, is lone under two conditions:
  // - It is at most max_lone_size_m wide.
  // - At least min_lone_meadow_ratio of the cells within lone_surroundings_m around it are meadow.
  double lone_allowance_m = 4.0;
  double max_lone_size_m = 8.0;
  double lone_surroundings_m = 3.0;
  double min_lone_meadow_ratio = 0.8;

  void Check() const;
};

// Defines which cells are certainly neither tree nor crop. In error messages the field is named
// `approach.…`.
struct ClearClassOptions {
  // A cell with at least this posterior of grass has a clear class. Its measured height includes
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
  // Least posterior of a grass cell. The risk of a landing adds up what is left (RiskOptions).
  double min_grass_posterior = 0.82;
  // Limits of the probability from one observation, because no single view is certain.
  double min_observation_probability = 0.1;
  double max_observation_probability = 0.9;
  // Errors of views are not independent (same light, same growth). The mean log-odds of a cell is
  // multiplied by its number of views, but at most by this number: then the posterior is as often
  // right as it says on textures that the network has not seen (decision 0052). Differs: the paper
  // takes the OR of all masks (Sec. III-G).
  double max_num_independent_views = 2.0;
  // The log-odds of cells are averaged within this distance where the photograph is even, because
  // what grows is the same over more than a cell, and the network's noise is not. Steps of at least
  // min_kind_contrast in the colour, as a share of full brightness, are kept: borders, footpaths.
  double kind_smoothing_m = 8.0;
  double min_kind_contrast = 0.017;
  // A cell gets a class only if at least this share of the views that see it classify it. Canopy
  // and rubble get no class, because nearly every view leaves them unclassified.
  double min_vote_ratio = 0.2;
  // A cell is a hazard if its upper height exceeds its elevation by more than max_roughness_m plus
  // this margin: a pole, bush or animal stands there. The upper height is the highest 95th
  // percentile of several stereo pairs. Its noise is 0.2 m, and the margin is 2.5 times that.
  double upper_margin_m = 0.5;
  // --- What looks like grass from above, but is not ---
  // Coarsest ground sampling distance at which rows and fences are visible. Coarser images
  // cause a warning.
  double max_telling_sampling_m = 0.35;
  // Crops in rows cause a peak in the spectrum of the photograph. min_row_strength is the least
  // power of this peak, relative to the median power at the same spacing. Spacings from
  // min_row_spacing_m to max_row_spacing_m are searched. 0: no search.
  double min_row_strength = 10.0;
  double min_row_spacing_m = 0.55;
  double max_row_spacing_m = 0.9;
  // Mown grass has rows, too. Where all views are as sure of grass as they can be, rows tell
  // nothing: crops are as rare there with them as without (decision 0052).
  double max_row_posterior = 0.985;
  // Least fine detail of grass, as a share of its brightness. Green ground with less detail is
  // water with algae, unless the views are as sure of grass as max_still_water_posterior, or take
  // it for something else than water if not for grass: a soft photograph shows little detail of
  // grass, too. min_detail_ratio = 0: no search.
  double min_detail_ratio = 0.015;
  double max_still_water_posterior = 0.95;
  // Grass counts as even up to these limits, which do not depend on the aircraft. Fences are
  // searched for on even grass.
  double max_even_slope_deg = 10.0;
  double max_even_roughness_m = 0.5;
  // Boulders, animals and cars differ from their surroundings in colour or brightness. An object is
  // a patch of at least min_object_area_m2 that differs by min_object_deviations deviations. The
  // surroundings are a square of side object_surroundings_m. min_object_deviations = 0: no search.
  double min_object_deviations = 7.0;
  double object_surroundings_m = 10.0;
  double min_object_area_m2 = 0.4;
  // The surroundings are measured again without pixels that deviate by more than this.
  double max_surroundings_deviations = 3.5;
  // A fence is a dark line of length fence_filter_length_m that contains min_num_posts posts. The
  // line must be darker than the ground on both sides by min_fence_deviations. The unit is the
  // standard deviation of the darkness of lines at arbitrary places. A post is a cell that is
  // darker than its surroundings by min_post_deviations. The unit is the standard deviation of the
  // darkness of single cells. min_fence_deviations = 0: no search.
  double min_fence_deviations = 3.0;
  double fence_filter_length_m = 16.0;
  double min_post_deviations = 4.0;
  int min_num_posts = 4;

  PhotoOptions photo;
  ClearClassOptions clear_class;

  void Check() const;
};

// What one view says of the ground, in image coordinates. It is projected onto the map.
struct KindView {
  Rigid3d world_from_camera;
  // Camera of the full-size image.
  Camera camera;
  KindPicture picture;
};

// The ground seen from straight above. Each cell is taken from the view that looks down on it most
// steeply.
struct Orthophoto {
  // Aligned with the map: each map cell consists of a whole number of these cells.
  Grid grid;
  cv::Mat3b image;  // BGR, as photographed; black where unseen
  cv::Mat1b seen;   // 255 or 0
  // The same ground from a second view, for comparison. Only views whose camera is far enough from
  // the first camera are considered (min_crossing_ratio). The steepest of them is used. Empty if
  // photographs are not compared.
  cv::Mat3b second_image;
  cv::Mat1b second_seen;
  // The views from which `image` and `second_image` are taken, one value per map cell. Index into
  // the block's views; -1 for none.
  cv::Mat1i view, second_view;
};

// Covers the ground that both the map and a connected view see. `images` returns full-size images.
// A frame whose image is empty is skipped. The orthophoto is empty if the map is empty.
Orthophoto MakeOrthophoto(const ElevationMap& map,
                          const AdjustedBlock& block,
                          const ImageSource& images,
                          const PhotoOptions& options);

// Result of comparing photographs. One value per map cell.
struct OpenCover {
  // 255 where photographs disagree, or where fewer than two photographs show the cell; else 0.
  // Where it is 255, the height is unreliable, and its deviation is unknown.
  cv::Mat1b is_unknown;
  // Metres to add to the map's upper height.
  cv::Mat1f allowance_m;
  // Whether photographs were compared. If not, both rasters are empty.
  bool is_compared = false;
};

// What one cue says of each cell, in steps that go into a byte.
struct CueLayer {
  // "views", or the rule that denies grass.
  std::string name;
  cv::Mat_<int8_t> steps;
};
struct CueSteps {
  // Of the log-odds of grass. Larger ones are kMost.
  static constexpr float kLogOdds = 1.0f / 16.0f;
  static constexpr int8_t kMost = 126;
  static constexpr int8_t kUnknown = 127;
  // The cue alone denies grass.
  static constexpr int8_t kVeto = -128;
};
int8_t CueStepOf(float log_odds);

struct GroundCover {
  // Posterior probability of grass. NaN where too few views classified the cell (min_vote_ratio). 0
  // where the orthophoto or the heights show a crop, water, a fence, an object or other ground. The
  // classes from the views do not count there.
  cv::Mat1f grass;
  // The likeliest kind of each cell (LikelyKind); 0 where it is not told. A cell that a rule denies
  // to be grass has another kind.
  cv::Mat1b kind;
  OpenCover open;
  // Why. One size with grass.
  std::vector<CueLayer> cues;
};

// If the orthophoto is empty, nothing is searched for.
GroundCover AssessCover(const ElevationMap& map,
                        const GroundSurface& surface,
                        const std::vector<KindView>& kind_views,
                        const CoverOptions& options,
                        Orthophoto photo = {});

// Applies the cover to the map. The deviation becomes NaN where the cover is unknown. The allowance
// is added to the upper height. If photographs were not compared, returns the map unchanged.
ElevationMap WithCover(const ElevationMap& map, const OpenCover& cover);

}  // namespace freelsd
