#include "engine/terrain/pair_summary.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace freelsd {
namespace {

// Ratio of standard deviation to median absolute deviation, normal distribution.
constexpr double kSigmaPerMad = 1.4826;
// With fewer points than this, the reference median includes the points of neighbouring cells.
constexpr size_t kMinReferencePoints = 5;
// Smaller deviations are unrealistic. Also keeps weights finite where the deviation is unknown.
constexpr double kMinDeviationM = 0.02;

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

// Upper percentile that at least `num_reaching` points reach; NaN with fewer points.
float UpperOf(const std::vector<float>& sorted, double percentile, size_t num_reaching) {
  if (sorted.size() < num_reaching) return kUnknown;
  const auto rank = static_cast<size_t>(percentile / 100.0 * (sorted.size() - 1));
  return sorted[std::min(rank, sorted.size() - num_reaching)];
}

// Median of the distances to the median. The nearest half of the heights is one run of the sorted
// heights around the median, so the run with the shortest reach gives the result.
float MedianDeviation(const std::vector<float>& sorted) {
  const size_t middle = sorted.size() / 2;
  float least = std::numeric_limits<float>::infinity();
  for (size_t first = 0; first + middle < sorted.size(); ++first) {
    least = std::min(
        least, std::max(sorted[middle] - sorted[first], sorted[first + middle] - sorted[middle]));
  }
  return least;
}

// Sorted heights of the points in the cells at most `reach` cells away.
void GatherHeights(
    const CellPoints& block, int row, int col, int reach, std::vector<float>& heights) {
  heights.clear();
  const int west = std::max(0, col - reach), east = std::min(block.cells.width - 1, col + reach);
  const int south = std::min(block.cells.height - 1, row + reach);
  for (int r = std::max(0, row - reach); r <= south; ++r) {
    const auto first = block.heights.begin();
    heights.insert(heights.end(),
                   first + block.start[block.IndexOf(r, west)],
                   first + block.start[block.IndexOf(r, east) + 1]);
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

CellSummary SummaryOf(const CellSums& sums, double base_height) {
  const double mean = sums.height / sums.weight;
  const double spread = std::max(0.0, sums.squared_height / sums.weight - mean * mean);
  // Errors of points are shared within a pair and do not average out; their spread does.
  const double variance = (sums.variance + spread) / sums.num_points;
  CellSummary summary;
  summary.num_points = static_cast<uint32_t>(sums.num_points);
  summary.mean = base_height + mean;
  summary.standard_deviation =
      static_cast<float>(std::sqrt(std::max(variance, kMinDeviationM * kMinDeviationM)));
  return summary;
}

// The cells that points in `cells` can reach.
cv::Rect Widened(const cv::Rect& cells, int reach, const Grid& grid) {
  const cv::Rect wide(
      cells.x - reach, cells.y - reach, cells.width + 2 * reach, cells.height + 2 * reach);
  return wide & cv::Rect(0, 0, grid.num_cols, grid.num_rows);
}

}  // namespace

PairSummarizer::PairSummarizer(const Grid& grid, const TerrainOptions& options)
    : grid_(grid), options_(options) {}

// Also forgets heights far from the cell's median.
PairSummarizer::Uppers PairSummarizer::JudgeCell(int row, int col) {
  const CellPoints& block = sorter_.sorted();
  const size_t cell = block.IndexOf(row, col);
  const size_t num_own = block.start[cell + 1] - block.start[cell];
  if (num_own == 0) return {kUnknown, kUnknown};
  GatherHeights(block, row, col, 0, heights_);
  // The highest point alone never counts.
  const Uppers uppers{
      UpperOf(heights_, options_.upper_percentile, 2),
      UpperOf(heights_, options_.upper_percentile, std::max(2, options_.min_num_points))};
  if (num_own < kMinReferencePoints) GatherHeights(block, row, col, 1, heights_);
  const float median = heights_[heights_.size() / 2];
  const double spread = kSigmaPerMad * MedianDeviation(heights_);
  const double deviation =
      std::sqrt(spread * spread + MeanVariance(block, cell) + kMinDeviationM * kMinDeviationM);
  const auto max_deviation = static_cast<float>(options_.outlier_sigma * deviation);
  for (uint32_t i = block.start[cell]; i < block.start[cell + 1]; ++i) {
    if (std::abs(block.heights[i] - median) > max_deviation) sorter_.ForgetHeight(i);
  }
  return uppers;
}

std::vector<CellSummary> PairSummarizer::SummariesOf(const WeightedSums& sums) const {
  const CellPoints& block = sorter_.sorted();
  const cv::Rect cells = sums.cells();
  std::vector<CellSummary> summaries;
  summaries.reserve(static_cast<size_t>(cells.area()));
  for (int row = cells.y; row < cells.br().y; ++row) {
    for (int col = cells.x; col < cells.br().x; ++col) {
      const CellSums sum = sums.At(row - cells.y, col - cells.x);
      if (sum.num_points == 0.0) continue;
      CellSummary summary = SummaryOf(sum, sums.base_height());
      summary.cell = static_cast<uint32_t>(row) * grid_.num_cols + col;
      const bool has_own = block.cells.contains({col, row});
      const Uppers uppers = has_own
                                ? uppers_[block.IndexOf(row - block.cells.y, col - block.cells.x)]
                                : Uppers{kUnknown, kUnknown};
      // fmax ignores NaN.
      summary.upper = std::fmax(uppers.upper, static_cast<float>(summary.mean));
      summary.firm_upper = std::fmax(uppers.firm_upper, static_cast<float>(summary.mean));
      summaries.push_back(summary);
    }
  }
  return summaries;
}

std::vector<CellSummary> PairSummarizer::Summarize(const Points& points) {
  sorter_.Sort(points, grid_, options_.max_relief_m);
  const CellPoints& block = sorter_.sorted();
  if (block.points.empty()) return {};
  const double base_height = block.heights.front();
  uppers_.clear();
  for (int row = 0; row < block.cells.height; ++row) {
    for (int col = 0; col < block.cells.width; ++col) uppers_.push_back(JudgeCell(row, col));
  }
  const int reach =
      static_cast<int>(std::ceil(options_.interpolation_radius_m / grid_.cell_size_m));
  WeightedSums sums(grid_,
                    Widened(block.cells, reach, grid_),
                    options_.interpolation_radius_m,
                    base_height,
                    SumKind::kAll);
  sums.Add(block.points.data(), block.points.size());
  return SummariesOf(sums);
}

}  // namespace freelsd
