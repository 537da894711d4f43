// Private to terrain/. One pair's estimate for each cell that it covers.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/terrain/cell_points.h"
#include "engine/terrain/terrain.h"
#include "engine/terrain/weighted_sums.h"

namespace freelsd {

struct CellSummary {
  // Index of the cell: row * num_cols + col.
  uint32_t cell = 0;
  // Number of points within the interpolation radius, without outliers.
  uint32_t num_points = 0;
  // Mean height, world z, weighted by inverse squared distance.
  double mean = 0.0;
  // Standard deviation of the mean.
  float standard_deviation = 0.0f;
  // Upper percentile (upper_percentile) of the points inside the cell. It is lowered until at least
  // two of these points reach it, but not below `mean`.
  float upper = 0.0f;
  // Like `upper`, but at least min_num_points points reach it.
  float firm_upper = 0.0f;
};

// Reuses its working memory for all pairs.
class PairSummarizer {
 public:
  PairSummarizer(const Grid& grid, const TerrainOptions& options);
  // Returns cells with at least one point within the interpolation radius, in row-major order.
  // Drops points outside the grid and points far from the median height (max_relief_m).
  std::vector<CellSummary> Summarize(const Points& points);

 private:
  // Upper percentiles of the points inside a cell; NaN if there are too few.
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
