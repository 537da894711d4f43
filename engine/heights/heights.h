// Input: heights that pairs of photographs propose, the adjusted views and their images. Output:
// the heights that all photographs of a place agree on, and where they cannot tell.
//
// Plane sweep in object space (vertical line locus; Collins 1996): small patches of ground that
// follow the map's slope are lifted to one height after another, and every view that sees them is
// resampled onto them. At the right height all views show the same.
#pragma once

#include <optional>
#include <vector>

#include "engine/terrain/terrain.h"

namespace freelsd {

enum class HeightMethod {
  kPairs,        // pairs of photographs alone; two photographs are compared from above (cover/)
  kPhotographs,  // pairs propose, all photographs decide
};

// Each field of cost is a trade of seconds for noise; freelsd-heights measures both.
struct HeightsOptions {
  // --- Behaviour ---
  HeightMethod method = HeightMethod::kPairs;
  // Heights from this far below to this far above the proposal are tried.
  double search_range_m = 2.0;
  // Something stands on the ground if it is higher than this. Does not depend on the aircraft.
  double min_thing_height_m = 0.5;
  // Share of cells of open ground on which something stands that the ground's height does not show.
  // Not measured: about the share in painted meadows.
  double thing_prior_probability = 0.01;
  // Above this probability something stands on a cell. If no height stands out then, the cell
  // cannot be told.
  double max_thing_probability = 0.05;
  // A cell with at least this many such cells among its 8 neighbours cannot be told either: the
  // twigs of a crown do not fill every cell.
  int min_num_thing_neighbours = 4;
  // Least gain (HeightEvidence) of a height that stands out; of one that pairs propose.
  double min_mode_gain = 1.0;
  double min_proposed_gain = 0.5;
  // The ground is compared in windows of two cells. Where the height's deviation by the curvature
  // of its peak is larger than this, in windows of three cells: ground with little contrast.
  double max_narrow_width_m = 0.03;
  // Side of the squares in which is compared what stands on the ground. A thing of three pixels
  // must fill it.
  double thing_window_m = 0.6;
  // The proposal is the lower surface of the map: what is narrower than this, and higher than its
  // surroundings, does not lift it.
  double proposal_window_m = 9.0;
  // Least number of views of a cell. The tables tell two views from three and more.
  int min_num_views = 2;
  // Least angle between the outermost views, as a baseline over height. Things of
  // min_thing_height_m must move by a pixel.
  double min_baseline_ratio = 0.25;
  // Least correlation of the views at the best height.
  double min_correlation = 0.3;
  // Least contrast of the ground, standard deviation of log brightness.
  double min_contrast = 0.01;

  // --- Cost ---
  // Views per cell, those that spread widest.
  int max_num_views = 8;
  // Views are not used beyond this horizontal distance, as a share of their height above ground:
  // there, things hide the ground behind them.
  double max_off_nadir_ratio = 1.2;
  // Spacing of samples on the ground; a map cell is a whole number of them.
  double ground_sampling_distance_m = 0.2;
  // Spacing of heights: disparity between the outermost views, in samples.
  double height_step_px = 0.5;

  void Check() const;
};

enum class CannotTell : uint8_t {
  kNothing,            // it can be told
  kTooFewViews,        // fewer than min_num_views show the cell, or one alone
  kTooLittleParallax,  // below min_baseline_ratio
  kNoContrast,         // below min_contrast: water, burnt-out ground, deep shade
  kNoHeightStandsOut,  // the views show different things at every height: twigs, movers, occlusion
};

// What was measured in a cell, before it is judged. Rasters in the cell order of terrain.h; NaN
// where nothing was measured.
struct HeightEvidence {
  // Height from which was searched up and down, world z.
  cv::Mat1f proposal;
  // World z of the best height, and the correlation of all views there, at most 1.
  cv::Mat1f ground, correlation;
  // Deviation of `ground` by the curvature of its peak, metres.
  cv::Mat1f peak_width;
  // Views compared, and the widest baseline over height among them.
  cv::Mat1f num_views, baseline_ratio;
  // Standard deviation of the log brightness of the ground, and of its difference between views.
  cv::Mat1f contrast, noise;
  // The smaller squares within the cell: logarithm of the variance between views at the ground's
  // height, of the square where it is largest.
  cv::Mat1f disagreement;
  // Largest logarithm of the variance at the ground's height over the least variance at a height
  // above it by min_thing_height_m or more; and this height, world z.
  cv::Mat1f gain, gain_height;
  // The same at the upper height that pairs propose, if it is within the heights that were tried.
  cv::Mat1f proposed_gain;
};

struct PhotographHeights {
  Grid grid;
  HeightEvidence evidence;
  // World z and its standard deviation; NaN where it cannot be told.
  cv::Mat1f ground, standard_deviation;
  // Highest height that is not unlikely; equal to the ground where nothing stands.
  cv::Mat1f upper;
  // Probability that something stands above the ground by more than min_thing_height_m.
  cv::Mat1f thing_probability;
  // CannotTell values.
  cv::Mat1b cannot_tell;
};

// Uses the seen cells of the proposal and the connected views. A frame whose image is empty, or has
// another size than the camera, is skipped. The result does not depend on the number of threads.
PhotographHeights MeasureHeights(const ElevationMap& proposal,
                                 const AdjustedBlock& block,
                                 const ImageSource& images,
                                 const HeightsOptions& options);

// The proposal with the measured heights. Where they cannot be told, the deviation is unknown.
// Cells of the proposal that stand higher than was searched keep their upper height.
ElevationMap WithHeights(const ElevationMap& proposal, const PhotographHeights& heights);

// By the method: the proposal itself, or the proposal with the measured heights.
ElevationMap DecideHeights(const ElevationMap& proposal,
                           const AdjustedBlock& block,
                           const ImageSource& images,
                           const HeightsOptions& options);

// How well each height of one place explains the photographs that show it: the evidence behind a
// cell of the map.
struct HeightLikelihood {
  // World z, ascending, evenly spaced.
  std::vector<double> heights;
  // Natural logarithm, 0 at the best height: the views' differences are normal, of unknown
  // variance.
  std::vector<double> log_likelihood;
  int num_views = 0;
  // Widest baseline over height among them.
  double baseline_ratio = 0.0;
  // Of the views at the best height, at most 1.
  double correlation = 0.0;
};

// `map`: seen cells around the place, which lies on its grid; their heights are searched up and
// down by search_range_m. Nothing if the place is unseen, or if fewer than two photographs with an
// image show it.
std::optional<HeightLikelihood> HeightLikelihoodAt(const Eigen::Vector2d& place_in_world,
                                                   const ElevationMap& map,
                                                   const AdjustedBlock& block,
                                                   const ImageSource& images,
                                                   const HeightsOptions& options);

}  // namespace freelsd
