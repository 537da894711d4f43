// Input: elevation map, grass observations and the picture from straight above. Output: slope,
// roughness, grass, hazard and the distance to it. Paper: Sec. III-G.
#pragma once

#include <vector>

#include "engine/terrain/terrain.h"

namespace freelsd {

enum class GrassFusion { kPosterior, kPaperOr };
enum class SlopeSupport { kPlane, kPaperPca };

struct HazardOptions {
  // --- Behaviour ---
  // Posterior over the observations of a cell, or the paper's OR of all fine masks.
  GrassFusion grass_fusion = GrassFusion::kPosterior;
  // More than one view alone can give (max_observation_probability): a second one must agree.
  double min_grass_posterior = 0.95;
  // Limits of one observation's probability: no single view is ever certain.
  double min_observation_probability = 0.1;
  double max_observation_probability = 0.9;
  // Views of one flight err together (same light, same growth): beyond this number they add no more
  // certainty, only their mean log-odds counts. Differs: spec asks for a posterior, 5 % of errors
  // are not independent at 4 Hz.
  double max_num_independent_views = 4.0;
  // Share of the views looking at a cell that must have classified it; below it the cell has no
  // class. Canopy and rubble are left unclassified by nearly every view, and one slip is no meadow.
  double min_vote_ratio = 0.2;
  // Plane fit over plane_support_m, or PCA of the 3x3 neighbourhood. Differs: 3x3 cells of 1 m are
  // mostly noise.
  SlopeSupport slope_support = SlopeSupport::kPlane;
  double plane_support_m = 9.0;
  // Share of the support's cells that must be seen. The support is whole: its cells outside the
  // grid are unseen.
  double min_support_ratio = 0.6;
  // Distance of the 8 neighbours of the roughness index, rounded to whole cells, at least one.
  // Differs: the paper's is one cell; the limit is meant for 1 m, so finer cells must not slacken
  // it.
  double roughness_spacing_m = 1.0;
  // A cell whose upper height stands above its elevation by more than max_roughness_m plus this is
  // a hazard: a pole, bush or animal within one cell. The margin is what noise alone does to the
  // highest of several pairs' 95th percentiles: about 2.5 deviations of 0.2 m.
  double upper_margin_m = 0.5;
  // Cells with a larger deviation of elevation are as good as unseen.
  double max_standard_deviation_m = 1.0;
  // --- What looks like grass from above, and is not ---
  // How much less green a rut is than the plants beside it, as a share of the brightness, over the
  // length of the filter. 0: tracks are not looked for, as in the paper.
  double min_rut_contrast = 0.03;
  double rut_filter_length_m = 8.0;
  double min_track_length_m = 15.0;
  // Distance of neighbouring tracks: the width of sprayers. Narrower ones are of mowers.
  double min_working_width_m = 6.0;
  double max_working_width_m = 42.0;
  // Where a pixel shows more ground than this, neither ruts nor rows nor fences can be seen: an
  // evaluation warns.
  double max_telling_sampling_m = 0.35;
  // What is sprayed reaches half a working width from a track, and this far beyond.
  double sprayed_margin_m = 2.0;
  // The rest of a field has the colour of what is sprayed, within so many of its deviations.
  double max_field_color_deviations = 2.0;
  // Crops in rows: how far the strongest direction stands out of the spectrum, in medians, for rows
  // of that distance. 0: not looked for.
  double min_row_strength = 10.0;
  double min_row_spacing_m = 0.55;
  double max_row_spacing_m = 0.9;
  // Water with algae has less fine detail than this, as a share of the brightness. 0: not looked
  // for.
  double min_detail_ratio = 0.015;
  // A crop whose leaves have met is as even as a meadow, but stands above what lies around: by at
  // least this much, over that much of its border and that share of what is known of it. 0: not
  // looked for.
  double min_raised_step_m = 0.6;
  double min_raised_border_m = 30.0;
  double min_raised_border_ratio = 0.3;
  // A border is known where both of its sides are planes of one slope but for so much; stereo makes
  // a ramp of the step, which is left out. It is one of pieces of grass no steeper and no rougher
  // than this, whatever aircraft asks.
  double max_border_residual_m = 0.25;
  double border_ramp_m = 3.0;
  double max_even_slope_deg = 10.0;
  double max_even_roughness_m = 0.5;
  // Segments reach over soft borders: what is called grass has the colour of the other ground
  // within that distance of it rather than that of the grass, where the two are so many deviations
  // apart. 0: not looked for.
  double min_overreach_deviations = 2.0;
  double overreach_surroundings_m = 30.0;
  // Boulders, animals, cars: what stands out of its surroundings in colour or brightness by so many
  // of their deviations, over at least that area. 0: not looked for.
  double min_object_deviations = 7.0;
  double object_surroundings_m = 10.0;
  double min_object_area_m2 = 0.4;
  // What is farther from them than this does not count as surroundings when they are taken anew.
  double max_surroundings_deviations = 3.5;
  // Fences: how dark a line of that length is against what is beside it, in deviations of lines
  // anywhere, and how many posts stand apart on it, each as many deviations of cells darker than
  // what surrounds it. 0: not looked for.
  double min_fence_deviations = 3.0;
  double fence_filter_length_m = 16.0;
  double min_post_deviations = 4.0;
  int min_num_posts = 4;

  void Check() const;
};

// Limits that make a cell a hazard; from the aircraft.
struct HazardLimits {
  // Less the deviation of the map's tilt: the whole map may lean.
  double max_slope_deg = 8.0;
  double max_roughness_m = 0.5;
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

// kUnseen: elevation, slope or roughness is unknown or too uncertain. kHazard: seen, and not grass
// (or of no class), too steep, too rough, or something stands in the cell. Only else kFree.
enum Hazard : uint8_t { kFree = 0, kHazard = 1, kUnseen = 2 };

struct HazardLayers {
  Grid grid;
  // Radians; NaN where unseen.
  cv::Mat1f slope;
  // Terrain ruggedness index (Riley): root of summed squared differences to 8 neighbours, metres.
  cv::Mat1f roughness;
  // Posterior probability of grass; NaN where no view, or too small a share, classified the cell.
  cv::Mat1f grass;
  // Cells that the views call grass and no rule calls a crop or water: 255, else 0. Fences and
  // things are of the meadow they stand in. Not kept with a site.
  cv::Mat1b meadow;
  // Cells in which the photograph shows a thing that stands out of the ground around it: 255, else
  // 0. Empty where none was looked for. Not kept with a site.
  cv::Mat1b objects;
  // Hazard values.
  cv::Mat1b hazard;
  // Metres from the cell's centre to the nearest centre of a cell that is not kFree, exact; the
  // outside of the grid is unseen, so it counts.
  cv::Mat1f distance;
};

// Where the photograph shows a green crop, water, a fence, a thing that stands in the meadow or the
// colour of other ground beside it, there is no grass, whatever the views say; without one (an
// empty picture) they are not looked for.
HazardLayers AssessHazards(const ElevationMap& map,
                           const std::vector<GrassView>& grass_views,
                           const HazardLimits& limits,
                           const HazardOptions& options,
                           const Orthophoto& photo = {});

// hazard and distance anew for other limits, from the layers that do not depend on them.
HazardLayers WithLimits(const ElevationMap& map,
                        const HazardLayers& layers,
                        const HazardLimits& limits,
                        const HazardOptions& options);

}  // namespace freelsd
