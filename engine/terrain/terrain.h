// Input: points in world. Output: 2.5D elevation map, and a picture of it. Paper: Sec. III-G.
//
// Cell order, for every raster of the map frame: row 0 is the northern edge, column 0 the western;
// one value per cell, at its centre. Unseen cells are NaN.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/stereo/stereo.h"

namespace freelsd {

struct Grid {
  // Outer corner of cell (0, 0), world east-north, metres.
  Eigen::Vector2d north_west_in_world = Eigen::Vector2d::Zero();
  double cell_size_m = 1.0;
  int num_rows = 0;
  int num_cols = 0;

  Eigen::Vector2d CellCenter(int row, int col) const;
  // Cell that holds the place; nothing outside the grid.
  std::optional<cv::Point> CellAt(const Eigen::Vector2d& place_in_world) const;  // x = col, y = row
  bool operator==(const Grid&) const = default;
};

enum class HeightFusion {
  kRobust,     // outliers clipped, upper heights kept, pairs weighed by their deviations
  kPaperMean,  // the weighted mean of all points of all pairs
};

struct TerrainOptions {
  // --- Behaviour ---
  // Differs: the paper's mean knows neither outliers nor its own error, and buries what stands in a
  // cell: upper is elevation there, standard_deviation 0 and num_points 1. Good to compare with,
  // not to land by, so the service does not offer it. Its sums depend on the order of the pairs.
  HeightFusion height_fusion = HeightFusion::kRobust;
  double cell_size_m = 1.0;
  // A point counts for cell centres within this distance, weight 1 / d^2. Paper: IDW in a radius.
  double interpolation_radius_m = 1.0;
  // Points within the radius that a cell needs, of all pairs that agree. A pair with fewer in a
  // cell is heard there only where no pair has enough: one wild landmark must not unsettle dense
  // ground.
  int min_num_points = 3;
  // Points farther than this many robust deviations from a cell's median are outliers, and so are
  // pairs from the median of a cell's pairs. Differs: the paper takes the plain mean.
  double outlier_sigma = 4.0;
  // Height that stands for what is in the cell: this percentile of a pair's points in it, highest
  // of the pairs. It counts if at least min_num_points points of one pair reach it, or two points
  // in each of two pairs: a single wild one never does. Means bury poles.
  double upper_percentile = 95.0;
  // Points farther than this from the median height of their pair are wild: clipped, as those
  // outside the grid, before anything is allocated.
  double max_relief_m = 150.0;
  // Cells of the largest grid that is built; a larger area is refused.
  int max_num_cells = 25000000;
  // Cells of the picture from straight above: a wheel's track is two of them wide.
  double orthophoto_cell_size_m = 0.25;
  // Two photographs of a place from cameras at least this share of the height apart, brought to the
  // map, must show the same, but for this much (deviation of the logarithm of brightness): or the
  // place is not at the height of the map. 0: photographs are not compared.
  double min_crossing_ratio = 0.2;
  double max_photo_disagreement = 0.06;
  // What they disagree about counts where a disc of this radius fits into it, or into it and ground
  // that was not seen, and so much around it: crowns, not the edges of a hedge.
  double min_open_cover_radius_m = 2.0;
  double open_cover_margin_m = 1.0;
  // Smaller crowns, of young trees and bushes, cannot be told from other edges: where what they
  // disagree about holds no such disc but a square of this side, the upper height gets so much on
  // top. Differs: spec 3.6 gives 2 m, to all that has no clear class; hedges carry saplings.
  double min_narrow_cover_m = 2.0;
  double narrow_cover_allowance_m = 2.5;
  // What stands alone in a meadow, narrow cover or an object of the picture, may be a sapling
  // without leaves, of which the map has next to nothing: so much on top instead. Alone: no wider
  // than this, and of what surrounds it so far that share is of a clear class.
  double lone_allowance_m = 4.0;
  double max_lone_size_m = 8.0;
  double lone_surroundings_m = 3.0;
  double min_lone_meadow_ratio = 0.8;

  void Check() const;
};

struct ElevationMap {
  Grid grid;
  // Metres above the world origin; NaN where unseen.
  cv::Mat1f elevation;
  // Upper height for clearance, >= elevation. Also of pairs that are outliers of elevation: a tree
  // that most pairs see through still stands there.
  cv::Mat1f upper;
  // Standard deviation of elevation, metres: the points' own and their spread within each pair,
  // widened where the pairs disagree by more than that.
  cv::Mat1f standard_deviation;
  // Points that elevation rests on; NaN where unseen.
  cv::Mat1f num_points;
  // Standard deviations of the map as a whole, which no number of points averages out: of its
  // horizontal position, along one axis, and of its tilt.
  double position_sd_m = 0.0;
  double tilt_sd_deg = 0.0;
  // Whether photographs were compared at these heights (MarkOpenCover).
  bool is_compared = false;

  bool IsSeen(int row, int col) const;
};

// Smallest grid of whole cells, aligned to multiples of the cell size, around the box.
// Throws std::invalid_argument on a box that is not finite or a cell size that is not positive.
Grid GridAround(const Eigen::Vector2d& min_in_world,
                const Eigen::Vector2d& max_in_world,
                double cell_size_m);

// Gathers points pair by pair, so that no cloud is ever held: memory is 32 bytes per pair and cell
// it covers, and working memory for the points of one pair. The result does not depend on the order
// of the pairs, to the bit. Not thread-safe.
class ElevationMapBuilder {
 public:
  // Throws std::invalid_argument on bad options and on a grid of more than max_num_cells. The cell
  // size is the grid's.
  ElevationMapBuilder(const Grid& grid, const TerrainOptions& options);
  ~ElevationMapBuilder();
  // Points of one pair (or the sparse landmarks, with their own deviations).
  void Add(const Points& points);
  ElevationMap Build() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// The ground from straight above, each cell from the view that looks down on it most steeply.
struct Orthophoto {
  // Its cells part those of the map it was made with.
  Grid grid;
  cv::Mat3b image;  // BGR, as photographed; black where unseen
  cv::Mat1b seen;   // 255 or 0
  // The same by the steepest view from elsewhere (min_crossing_ratio); empty if not compared.
  cv::Mat3b second_image;
  cv::Mat1b second_seen;
  // The views of both, index into the block's; below zero where there is none. By the map's cells.
  cv::Mat1i view, second_view;
};

// Only ground that the map sees and a connected view shows. `images` gives full-size images; empty
// ones are left out. Empty for an empty map.
Orthophoto MakeOrthophoto(const ElevationMap& map,
                          const AdjustedBlock& block,
                          const ImageSource& images,
                          const TerrainOptions& options);

// Twigs of a leafless crown move against the ground below from view to view, and the map has the
// ground's height. Where both photographs do not show the same, or only one shows anything, the
// map's standard deviation becomes unknown: NaN. Over narrow cover, and over objects of the picture
// (255, else 0; may be empty) that stand alone in a meadow, the upper height grows instead. What
// they show differently of cells of a clear class (255, else 0) is left: grass is no tree.
// `is_meadow`: what is around a lone thing, whatever else was found there. Does nothing with a
// picture of one view. Once for each map: the upper height grows every time.
void MarkOpenCover(const Orthophoto& photo,
                   const cv::Mat1b& is_clear_class,
                   const cv::Mat1b& is_meadow,
                   const cv::Mat1b& objects,
                   const TerrainOptions& options,
                   ElevationMap& map);

}  // namespace freelsd
