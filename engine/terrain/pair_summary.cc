#include "engine/terrain/pair_summary.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/terrain/cell_points.h"
#include "engine/terrain/weighted_sums.h"

namespace freelsd {
namespace {

// Normal deviation from the median absolute one.
constexpr double kSigmaPerMad = 1.4826;
// Below this many points a cell's own median is no reference: its neighbours' points join in.
constexpr size_t kMinReferencePoints = 5;
// Deviations below this are wishful; also keeps weights finite where a caller knows no deviation.
constexpr double kMinDeviationM = 0.02;

// What a cell's points have in common.
struct Reference {
  float median = 0.0f;
  float max_deviation = 0.0f;
  // NaN where too few points lie in the cell.
  float upper = std::numeric_limits<float>::quiet_NaN();
  float firm_upper = std::numeric_limits<float>::quiet_NaN();
};

// The upper percentile that at least `num_reaching` points reach; NaN where there are not as many.
float UpperOf(const std::vector<float>& sorted, double percentile, size_t num_reaching) {
  if (sorted.size() < num_reaching) return std::numeric_limits<float>::quiet_NaN();
  const auto rank = static_cast<size_t>(percentile / 100.0 * (sorted.size() - 1));
  return sorted[std::min(rank, sorted.size() - num_reaching)];
}

// Median of the distances to the middle one, walking outwards from it.
float MedianDeviation(const std::vector<float>& sorted) {
  const size_t middle = sorted.size() / 2;
  size_t below = middle, above = middle;
  float deviation = 0.0f;
  for (size_t i = 0; i < middle; ++i) {
    const bool goes_up =
        below == 0 || (above + 1 < sorted.size() &&
                       sorted[above + 1] - sorted[middle] < sorted[middle] - sorted[below - 1]);
    deviation = goes_up ? sorted[++above] - sorted[middle] : sorted[middle] - sorted[--below];
  }
  return deviation;
}

// Sorted heights of the points in the cells at most `reach` cells away.
void GatherHeights(
    const CellPoints& block, int row, int col, int reach, std::vector<float>& heights) {
  heights.clear();
  const int west = std::max(0, col - reach), east = std::min(block.cells.width - 1, col + reach);
  const int south = std::min(block.cells.height - 1, row + reach);
  for (int r = std::max(0, row - reach); r <= south; ++r) {
    const uint32_t end = block.start[block.IndexOf(r, east) + 1];
    for (uint32_t i = block.start[block.IndexOf(r, west)]; i < end; ++i) {
      heights.push_back(block.points[i].point_in_world.z());
    }
  }
  SortHeights(heights);
}

double MeanVariance(const CellPoints& block, size_t cell) {
  double sum = 0.0;
  for (uint32_t i = block.start[cell]; i < block.start[cell + 1]; ++i) {
    sum += block.points[i].height_sd_m * block.points[i].height_sd_m;
  }
  return sum / (block.start[cell + 1] - block.start[cell]);
}

// `heights` is working space.
Reference ReferenceOf(const CellPoints& block,
                      int row,
                      int col,
                      const TerrainOptions& options,
                      std::vector<float>& heights) {
  const size_t cell = block.IndexOf(row, col);
  const size_t num_own = block.start[cell + 1] - block.start[cell];
  Reference reference;
  if (num_own == 0) return reference;
  GatherHeights(block, row, col, 0, heights);
  // The highest point alone never counts.
  reference.upper = UpperOf(heights, options.upper_percentile, 2);
  reference.firm_upper =
      UpperOf(heights, options.upper_percentile, std::max(2, options.min_num_points));
  if (num_own < kMinReferencePoints) GatherHeights(block, row, col, 1, heights);
  reference.median = heights[heights.size() / 2];
  const double spread = kSigmaPerMad * MedianDeviation(heights);
  const double deviation =
      std::sqrt(spread * spread + MeanVariance(block, cell) + kMinDeviationM * kMinDeviationM);
  reference.max_deviation = static_cast<float>(options.outlier_sigma * deviation);
  return reference;
}

std::vector<Reference> References(const CellPoints& block, const TerrainOptions& options) {
  std::vector<Reference> references(block.start.size() - 1);
  std::vector<float> heights;
  for (int row = 0; row < block.cells.height; ++row) {
    for (int col = 0; col < block.cells.width; ++col) {
      references[block.IndexOf(row, col)] = ReferenceOf(block, row, col, options, heights);
    }
  }
  return references;
}

// Without those far from their cell's median.
Points Inliers(const CellPoints& block, const std::vector<Reference>& references) {
  Points inliers;
  inliers.reserve(block.points.size());
  for (size_t cell = 0; cell < references.size(); ++cell) {
    const Reference& reference = references[cell];
    for (uint32_t i = block.start[cell]; i < block.start[cell + 1]; ++i) {
      const DensePoint& point = block.points[i];
      const float deviation = std::abs(point.point_in_world.z() - reference.median);
      if (deviation <= reference.max_deviation) {
        inliers.push_back(point);
      }
    }
  }
  return inliers;
}

CellSummary Summarize(const CellSums& sums, double base_height) {
  const double mean = sums.height / sums.weight;
  const double spread = std::max(0.0, sums.squared_height / sums.weight - mean * mean);
  // The points' own errors are shared within a pair and do not average out; their spread does.
  const double variance = (sums.variance + spread) / sums.num_points;
  CellSummary summary;
  summary.num_points = static_cast<uint32_t>(sums.num_points);
  summary.mean = base_height + mean;
  summary.standard_deviation =
      static_cast<float>(std::sqrt(std::max(variance, kMinDeviationM * kMinDeviationM)));
  return summary;
}

// What the points in the cell at (row, col) of the grid have in common; nothing of none.
Reference ReferenceAt(const CellPoints& block,
                      const std::vector<Reference>& references,
                      const cv::Point& cell) {
  if (!block.cells.contains(cell)) return {};
  return references[block.IndexOf(cell.y - block.cells.y, cell.x - block.cells.x)];
}

// The cells that points of these can reach.
cv::Rect Widened(const cv::Rect& cells, int reach, const Grid& grid) {
  const cv::Rect wide(
      cells.x - reach, cells.y - reach, cells.width + 2 * reach, cells.height + 2 * reach);
  return wide & cv::Rect(0, 0, grid.num_cols, grid.num_rows);
}

}  // namespace

std::vector<CellSummary> SummarizePair(const Points& points,
                                       const Grid& grid,
                                       const TerrainOptions& options) {
  const CellPoints block = SortIntoCells(points, grid, options.max_relief_m);
  if (block.points.empty()) return {};
  const std::vector<Reference> references = References(block, options);
  const int reach = static_cast<int>(std::ceil(options.interpolation_radius_m / grid.cell_size_m));
  const cv::Rect cells = Widened(block.cells, reach, grid);
  WeightedSums sums(grid,
                    cells,
                    options.interpolation_radius_m,
                    block.points.front().point_in_world.z(),
                    SumKind::kAll);
  const Points inliers = Inliers(block, references);
  sums.Add(inliers.data(), inliers.size());

  std::vector<CellSummary> summaries;
  summaries.reserve(static_cast<size_t>(cells.area()));
  for (int row = cells.y; row < cells.br().y; ++row) {
    for (int col = cells.x; col < cells.br().x; ++col) {
      const CellSums sum = sums.At(row - cells.y, col - cells.x);
      if (sum.num_points == 0.0) continue;
      CellSummary summary = Summarize(sum, sums.base_height());
      summary.cell = static_cast<uint32_t>(row) * grid.num_cols + col;
      const Reference reference = ReferenceAt(block, references, {col, row});
      // fmax ignores NaN.
      summary.upper = std::fmax(reference.upper, static_cast<float>(summary.mean));
      summary.firm_upper = std::fmax(reference.firm_upper, static_cast<float>(summary.mean));
      summaries.push_back(summary);
    }
  }
  return summaries;
}

}  // namespace freelsd
