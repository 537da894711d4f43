// Input: points in world. Output: 2.5D elevation map, its slope and roughness. Paper: Sec. III-G.
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
  // Cells of the grid that intersect the polygon's bounding box, widened by `reach` metres. If the
  // box's eastern or southern edge is on a grid line, the cells beyond that line are not included.
  cv::Rect CellsAround(const Polygon& polygon, double reach) const;
  // Cells whose centre lies in the polygon, row by row.
  std::vector<cv::Point> CellsIn(const Polygon& polygon) const;
  // The grid of some of its cells.
  Grid Part(const cv::Rect& cells) const;
  bool operator==(const Grid&) const = default;
};

enum class HeightFusion {
  kRobust,     // outliers clipped, upper heights kept, pairs weighted by their deviations
  kPaperMean,  // the weighted mean of all points of all pairs
};

struct TerrainOptions {
  // --- Behaviour ---
  // Differs: the paper's mean has no outlier rejection and no error estimate, and hides objects.
  // With kPaperMean, upper equals elevation, standard_deviation is 0, num_points is 1, and the
  // result depends on the order of the pairs. It is for comparison only: the service offers it only
  // as a part of Preset::kPaper.
  HeightFusion height_fusion = HeightFusion::kRobust;
  double cell_size_m = 1.0;
  // A point contributes to all cells whose centre is within this distance d, with weight 1 / d^2.
  // Paper: inverse-distance weighting in a radius.
  double interpolation_radius_m = 1.0;
  // Least number of points within interpolation_radius_m of a seen cell, summed over the pairs that
  // agree. A pair with fewer points counts only in cells where no pair has enough. Otherwise one
  // outlier among the landmarks could disturb dense ground.
  int min_num_points = 3;
  // A point is an outlier if it is farther than this many robust deviations from the median of its
  // pair's cell. Differs: the paper takes the plain mean.
  double outlier_sigma = 4.0;
  // Two pairs agree on a height if they differ by at most this, or by at most pair_agreement_sigma
  // deviations. The height of a cell is that on which most of its pairs agree. Without such a
  // majority it is unseen. Nothing checks one pair, and two cannot tell which of them is wrong:
  // their deviation is larger by unchecked_factor.
  double max_pair_disagreement_m = 0.35;
  double pair_agreement_sigma = 2.0;
  double unchecked_factor = 2.0;
  // For each pair, this percentile of the pair's points in a cell is taken. The upper height of the
  // cell is the highest of these values. At least min_num_points points of one pair must reach it,
  // or two points in each of two pairs. A single outlier therefore never sets it. A mean would hide
  // poles.
  double upper_percentile = 95.0;
  // Points farther than this from the median height of their pair are outliers. Like points outside
  // the grid, they are dropped before memory is allocated.
  double max_relief_m = 150.0;
  // Largest number of cells of a grid. A larger grid is an error.
  int max_num_cells = 25000000;

  void Check() const;
};

struct ElevationMap {
  Grid grid;
  // Metres above the world origin; NaN where unseen.
  cv::Mat1f elevation;
  // Upper height for clearance, >= elevation. Includes pairs that are outliers of elevation: a tree
  // is an obstacle even if most pairs see the ground through it.
  cv::Mat1f upper;
  // Standard deviation of elevation, metres: of what the agreeing pairs differ by, and at least
  // what the errors of their points and the spread of these tell.
  cv::Mat1f standard_deviation;
  // Number of points that the elevation is computed from; NaN where unseen.
  cv::Mat1f num_points;
  // Standard deviations of the whole map: of its horizontal position along one axis, and of its
  // tilt. More points do not reduce them.
  double position_sd_m = 0.0;
  double tilt_sd_deg = 0.0;
  // Whether photographs were compared on this map (WithCover).
  bool is_compared = false;

  bool IsSeen(int row, int col) const;
};

// Smallest grid of whole cells, aligned to multiples of the cell size, around the box.
// Throws std::invalid_argument on a box that is not finite or a cell size that is not positive.
Grid GridAround(const Eigen::Vector2d& min_in_world,
                const Eigen::Vector2d& max_in_world,
                double cell_size_m);

// Adds points pair by pair, without holding the whole point cloud in memory. Uses 32 bytes per pair
// and covered cell, plus working memory for one pair. With kRobust, the result is bit-identical for
// every order of the pairs. Not thread-safe.
class ElevationMapBuilder {
 public:
  // Throws std::invalid_argument on bad options and on a grid of more than max_num_cells. Uses the
  // grid's cell size.
  ElevationMapBuilder(const Grid& grid, const TerrainOptions& options);
  ~ElevationMapBuilder();
  // Adds the points of one pair, or the sparse landmarks with their own deviations.
  void Add(const Points& points);
  ElevationMap Build() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

enum class SlopeSupport { kPlane, kPaperPca };

// In error messages the fields are named `hazard.…`.
struct SurfaceOptions {
  // kPlane fits a plane over plane_support_m; kPaperPca uses PCA of the 3x3 neighbourhood. Differs:
  // slopes from 3x3 cells of 1 m are mostly noise.
  SlopeSupport slope_support = SlopeSupport::kPlane;
  double plane_support_m = 9.0;
  // Least share of seen cells in the square of side plane_support_m. Cells outside the grid count
  // as unseen.
  double min_support_ratio = 0.6;
  // Distance from a cell to the 8 neighbours that its roughness is computed from. Rounded to whole
  // cells, at least one. Differs: the paper's distance is one cell. max_roughness_m is meant for a
  // distance of 1 m. With smaller cells, the paper's rule would accept rougher ground.
  double roughness_spacing_m = 1.0;
  // Cells with a larger deviation of elevation count as unseen.
  double max_standard_deviation_m = 1.0;

  void Check() const;
};

// Shape of the ground, cell by cell; NaN where unseen.
struct GroundSurface {
  // Elevation where its deviation is small enough, metres above the world origin.
  cv::Mat1f elevation;
  // Radians.
  cv::Mat1f slope;
  // Terrain ruggedness index (Riley): square root of the sum of squared height differences to the 8
  // neighbours, metres.
  cv::Mat1f roughness;
};

GroundSurface MeasureSurface(const ElevationMap& map, const SurfaceOptions& options);

}  // namespace freelsd
