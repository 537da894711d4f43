// Private to terrain/. One pair's estimate for each cell that it covers.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/terrain/cell_points.h"
#include "engine/terrain/terrain.h"
#include "engine/terrain/weighted_sums.h"

namespace freelsd {

struct CellSummary {
  // row * num_cols + col.
  uint32_t cell = 0;
  // Within the interpolation radius, outliers not counted.
  uint32_t num_points = 0;
  // Inverse-distance weighted mean height, world z.
  double mean = 0.0;
  // Standard deviation of the mean.
  float standard_deviation = 0.0f;
  // Upper percentile of the cell's own points, >= mean, reached by at least two points.
  float upper = 0.0f;
  // The same, reached by at least min_num_points points.
  float firm_upper = 0.0f;
};

// Keeps its working memory from pair to pair.
class PairSummarizer {
 public:
  PairSummarizer(const Grid& grid, const TerrainOptions& options);
  // Cells in row-major order, only those with at least one point. Drops points outside the grid and
  // wild points (max_relief_m).
  std::vector<CellSummary> Summarize(const Points& points);

 private:
  // Upper percentiles of a cell's own points; NaN where there are too few.
  struct Uppers {
    float upper;
    float firm_upper;
  };
  Uppers JudgeCell(int row, int col);
  std::vector<CellSummary> SummariesOf(const WeightedSums& sums) const;

  Grid grid_;
  TerrainOptions options_;
  CellSorter sorter_;
  std::vector<Uppers> uppers_;
  std::vector<float> heights_;
};

}  // namespace freelsd
