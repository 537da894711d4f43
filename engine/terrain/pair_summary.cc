#include "engine/terrain/pair_summary.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace freelsd {
namespace {

// A point this near to a cell's centre decides its height alone; nearer makes no difference.
constexpr double kExactHitM = 1e-6;
// Normal deviation from the median absolute one.
constexpr double kSigmaPerMad = 1.4826;
// Below this many points a cell's own median is no reference: its neighbours' points join in.
constexpr size_t kMinReferencePoints = 5;
// Deviations below this are wishful; also keeps weights finite where a caller knows no deviation.
constexpr double kMinDeviationM = 0.02;

// A point in units of cells from the grid's north-west corner: u east, v south.
struct MapPoint {
  double u;
  double v;
  float height;
  float height_sd;
};

// Block of the grid around the points of a pair; `points` are sorted by cell, row-major.
struct Block {
  int first_row = 0;
  int first_col = 0;
  int num_rows = 0;
  int num_cols = 0;
  std::vector<MapPoint> points;
  // points[start[i] .. start[i + 1]) lie in cell i of the block.
  std::vector<uint32_t> start;

  size_t IndexOf(const MapPoint& point) const {
    return static_cast<size_t>(static_cast<int>(point.v) - first_row) * num_cols +
           (static_cast<int>(point.u) - first_col);
  }
};

// What a cell's points have in common.
struct Reference {
  float median = 0.0f;
  float max_deviation = 0.0f;
  // NaN where too few points lie in the cell.
  float upper = std::numeric_limits<float>::quiet_NaN();
  float firm_upper = std::numeric_limits<float>::quiet_NaN();
};

struct Accumulator {
  double weight = 0.0;
  double height = 0.0;
  double squared_height = 0.0;
  double variance = 0.0;
  uint32_t num_points = 0;
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

std::vector<MapPoint> PointsInGrid(const Points& points, const Grid& grid) {
  std::vector<MapPoint> inside;
  inside.reserve(points.size());
  for (const DensePoint& point : points) {
    const double u = (point.point_in_world.x() - grid.north_west_in_world.x()) / grid.cell_size_m;
    const double v = (grid.north_west_in_world.y() - point.point_in_world.y()) / grid.cell_size_m;
    const bool is_inside = u >= 0.0 && v >= 0.0 && u < grid.num_cols && v < grid.num_rows;
    const bool is_known = std::isfinite(point.point_in_world.z()) &&
                          std::isfinite(point.height_sd_m) && point.height_sd_m >= 0.0f;
    if (!is_inside || !is_known) continue;
    inside.push_back({u, v, point.point_in_world.z(), point.height_sd_m});
  }
  return inside;
}

void DropWild(std::vector<MapPoint>& points, double max_relief_m) {
  if (points.empty()) return;
  std::vector<float> heights(points.size());
  std::transform(
      points.begin(), points.end(), heights.begin(), [](const auto& p) { return p.height; });
  const auto middle = heights.begin() + static_cast<ptrdiff_t>(heights.size() / 2);
  std::nth_element(heights.begin(), middle, heights.end());
  const double median = *middle;
  std::erase_if(points, [median, max_relief_m](const MapPoint& point) {
    return std::abs(point.height - median) > max_relief_m;
  });
}

// Counting sort by cell; stable, so the order within a cell is that of the points.
Block SortByCell(const std::vector<MapPoint>& points) {
  Block block;
  block.first_row = block.first_col = std::numeric_limits<int>::max();
  int last_row = 0, last_col = 0;
  for (const MapPoint& point : points) {
    block.first_row = std::min(block.first_row, static_cast<int>(point.v));
    block.first_col = std::min(block.first_col, static_cast<int>(point.u));
    last_row = std::max(last_row, static_cast<int>(point.v));
    last_col = std::max(last_col, static_cast<int>(point.u));
  }
  block.num_rows = last_row - block.first_row + 1;
  block.num_cols = last_col - block.first_col + 1;
  block.start.assign(static_cast<size_t>(block.num_rows) * block.num_cols + 1, 0);
  for (const MapPoint& point : points) ++block.start[block.IndexOf(point) + 1];
  for (size_t i = 1; i < block.start.size(); ++i) block.start[i] += block.start[i - 1];
  std::vector<uint32_t> next(block.start.begin(), block.start.end() - 1);
  block.points.resize(points.size());
  for (const MapPoint& point : points) block.points[next[block.IndexOf(point)]++] = point;
  return block;
}

// Sorted heights of the points in the cells at most `reach` cells away.
void GatherHeights(const Block& block, int row, int col, int reach, std::vector<float>& heights) {
  heights.clear();
  const int west = std::max(0, col - reach), east = std::min(block.num_cols - 1, col + reach);
  for (int r = std::max(0, row - reach); r <= std::min(block.num_rows - 1, row + reach); ++r) {
    const size_t line = static_cast<size_t>(r) * block.num_cols;
    for (uint32_t i = block.start[line + west]; i < block.start[line + east + 1]; ++i) {
      heights.push_back(block.points[i].height);
    }
  }
  std::sort(heights.begin(), heights.end());
}

double MeanVariance(const Block& block, size_t cell) {
  double sum = 0.0;
  for (uint32_t i = block.start[cell]; i < block.start[cell + 1]; ++i) {
    sum += block.points[i].height_sd * block.points[i].height_sd;
  }
  return sum / (block.start[cell + 1] - block.start[cell]);
}

// `heights` is working space.
Reference ReferenceOf(const Block& block,
                      int row,
                      int col,
                      const TerrainOptions& options,
                      std::vector<float>& heights) {
  const size_t cell = static_cast<size_t>(row) * block.num_cols + col;
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

std::vector<Reference> References(const Block& block, const TerrainOptions& options) {
  std::vector<Reference> references(block.start.size() - 1);
  std::vector<float> heights;
  for (int row = 0; row < block.num_rows; ++row) {
    for (int col = 0; col < block.num_cols; ++col) {
      references[static_cast<size_t>(row) * block.num_cols + col] =
          ReferenceOf(block, row, col, options, heights);
    }
  }
  return references;
}

// Sums of the cells of a block that is `reach` cells wider on each side than the points'.
struct Sums {
  int first_row = 0;
  int first_col = 0;
  int num_rows = 0;
  int num_cols = 0;
  // Heights are summed relative to this one.
  double base_height = 0.0;
  std::vector<Accumulator> cells;
};

Sums EmptySums(const Block& block, const Grid& grid, int reach) {
  Sums sums;
  sums.first_row = std::max(0, block.first_row - reach);
  sums.first_col = std::max(0, block.first_col - reach);
  sums.num_rows =
      std::min(grid.num_rows, block.first_row + block.num_rows + reach) - sums.first_row;
  sums.num_cols =
      std::min(grid.num_cols, block.first_col + block.num_cols + reach) - sums.first_col;
  sums.base_height = block.points.front().height;
  sums.cells.resize(static_cast<size_t>(sums.num_rows) * sums.num_cols);
  return sums;
}

// Adds the point to every cell whose centre is within the radius. Cell centres are at n + 0.5.
void Scatter(const MapPoint& point, const Grid& grid, double radius_m, Sums& sums) {
  const double reach = radius_m / grid.cell_size_m;
  const double u = point.u - 0.5 - sums.first_col, v = point.v - 0.5 - sums.first_row;
  const int west = std::max(0, static_cast<int>(std::ceil(u - reach)));
  const int east = std::min(sums.num_cols - 1, static_cast<int>(std::floor(u + reach)));
  const int north = std::max(0, static_cast<int>(std::ceil(v - reach)));
  const int south = std::min(sums.num_rows - 1, static_cast<int>(std::floor(v + reach)));
  const double height = point.height - sums.base_height;
  const double cell_area = grid.cell_size_m * grid.cell_size_m;
  for (int row = north; row <= south; ++row) {
    for (int col = west; col <= east; ++col) {
      const double squared = ((u - col) * (u - col) + (v - row) * (v - row)) * cell_area;
      if (squared > radius_m * radius_m) continue;
      const double weight = 1.0 / std::max(squared, kExactHitM * kExactHitM);
      Accumulator& cell = sums.cells[static_cast<size_t>(row) * sums.num_cols + col];
      cell.weight += weight;
      cell.height += weight * height;
      cell.squared_height += weight * height * height;
      cell.variance += point.height_sd * point.height_sd;
      ++cell.num_points;
    }
  }
}

CellSummary Summarize(const Accumulator& cell, double base_height) {
  const double mean = cell.height / cell.weight;
  const double spread = std::max(0.0, cell.squared_height / cell.weight - mean * mean);
  // The points' own errors are shared within a pair and do not average out; their spread does.
  const double variance = (cell.variance + spread) / cell.num_points;
  CellSummary summary;
  summary.num_points = cell.num_points;
  summary.mean = base_height + mean;
  summary.standard_deviation =
      static_cast<float>(std::sqrt(std::max(variance, kMinDeviationM * kMinDeviationM)));
  return summary;
}

// What the points in the cell at (row, col) of the grid have in common; nothing of none.
Reference ReferenceAt(const Block& block,
                      const std::vector<Reference>& references,
                      int row,
                      int col) {
  const int r = row - block.first_row, c = col - block.first_col;
  const bool is_inside = r >= 0 && c >= 0 && r < block.num_rows && c < block.num_cols;
  return is_inside ? references[static_cast<size_t>(r) * block.num_cols + c] : Reference{};
}

}  // namespace

std::vector<CellSummary> SummarizePair(const Points& points,
                                       const Grid& grid,
                                       const TerrainOptions& options) {
  std::vector<MapPoint> inside = PointsInGrid(points, grid);
  DropWild(inside, options.max_relief_m);
  if (inside.empty()) return {};
  const Block block = SortByCell(inside);
  const std::vector<Reference> references = References(block, options);

  const int reach = static_cast<int>(std::ceil(options.interpolation_radius_m / grid.cell_size_m));
  Sums sums = EmptySums(block, grid, reach);
  for (const MapPoint& point : block.points) {
    const Reference& reference = references[block.IndexOf(point)];
    if (std::abs(point.height - reference.median) > reference.max_deviation) continue;
    Scatter(point, grid, options.interpolation_radius_m, sums);
  }

  std::vector<CellSummary> summaries;
  for (size_t i = 0; i < sums.cells.size(); ++i) {
    if (sums.cells[i].num_points == 0) continue;
    const int row = sums.first_row + static_cast<int>(i / sums.num_cols);
    const int col = sums.first_col + static_cast<int>(i % sums.num_cols);
    CellSummary summary = Summarize(sums.cells[i], sums.base_height);
    summary.cell = static_cast<uint32_t>(row) * grid.num_cols + col;
    const Reference reference = ReferenceAt(block, references, row, col);
    // fmax ignores NaN.
    summary.upper = std::fmax(reference.upper, static_cast<float>(summary.mean));
    summary.firm_upper = std::fmax(reference.firm_upper, static_cast<float>(summary.mean));
    summaries.push_back(summary);
  }
  return summaries;
}

}  // namespace freelsd
