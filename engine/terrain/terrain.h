// Input: points in world. Output: 2.5D elevation map. Paper: Sec. III-G.
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

struct TerrainOptions {
  // --- Behaviour ---
  double cell_size_m = 1.0;
  // A point counts for cell centres within this distance, weight 1 / d^2. Paper: IDW in a radius.
  double interpolation_radius_m = 1.0;
  // Points of one pair that a cell needs, and pairs (or one pair with all its points agreeing).
  int min_num_points = 3;
  // Points farther than this many robust deviations from a cell's median are outliers.
  double outlier_sigma = 4.0;
  // Height that stands for what is in the cell: this percentile of its points. Means bury poles.
  double upper_percentile = 95.0;
  // Points outside this range about the landmarks' heights are wild: clipped before allocating.
  double max_relief_m = 150.0;
  // Cells of the largest grid that is built; a larger area is refused.
  int max_num_cells = 25000000;

  void Check() const;
};

struct ElevationMap {
  Grid grid;
  // Metres above the world origin; NaN where unseen.
  cv::Mat1f elevation;
  // Upper height for clearance, >= elevation.
  cv::Mat1f upper;
  // Standard deviation of elevation from the points' own and their spread.
  cv::Mat1f standard_deviation;
  cv::Mat1f num_points;

  bool IsSeen(int row, int col) const;
};

// Smallest grid of whole cells, aligned to multiples of the cell size, around the box.
Grid GridAround(const Eigen::Vector2d& min_in_world,
                const Eigen::Vector2d& max_in_world,
                double cell_size_m);

// Gathers points pair by pair, so that no cloud is ever held. The result does not depend on the
// order of the pairs.
class ElevationMapBuilder {
 public:
  ElevationMapBuilder(const Grid& grid, const TerrainOptions& options);
  ~ElevationMapBuilder();
  // Points of one pair (or the sparse landmarks, with their own deviations).
  void Add(const Points& points);
  ElevationMap Build() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace freelsd
