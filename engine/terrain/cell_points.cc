#include "engine/terrain/cell_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace freelsd {
namespace {

struct Cell {
  int row = 0;
  int col = 0;
};
// Of a point that is left out.
constexpr int kNowhere = -1;
// Up to this many heights, ranks by comparing all with all are faster than sorting: no branch.
constexpr size_t kMaxNumRanked = 64;

std::vector<Cell> CellsOf(const Points& points, const Grid& grid) {
  constexpr float kLargest = std::numeric_limits<float>::max();
  const double west = grid.north_west_in_world.x(), north = grid.north_west_in_world.y();
  std::vector<Cell> cells(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f& place = points[i].point_in_world;
    const double u = (place.x() - west) / grid.cell_size_m;
    const double v = (north - place.y()) / grid.cell_size_m;
    const bool is_inside = (u >= 0.0) & (v >= 0.0) & (u < grid.num_cols) & (v < grid.num_rows) &
                           (std::abs(place.z()) <= kLargest) & (points[i].height_sd_m >= 0.0f) &
                           (points[i].height_sd_m <= kLargest);
    cells[i] = {is_inside ? static_cast<int>(v) : kNowhere, is_inside ? static_cast<int>(u) : 0};
  }
  return cells;
}

void DropWild(const Points& points, double max_relief_m, std::vector<Cell>& cells) {
  float low = std::numeric_limits<float>::infinity(), high = -low;
  for (size_t i = 0; i < points.size(); ++i) {
    if (cells[i].row == kNowhere) continue;
    low = std::min(low, points[i].point_in_world.z());
    high = std::max(high, points[i].point_in_world.z());
  }
  // Nothing is farther from the median than the range is wide.
  if (high - low <= max_relief_m || low > high) return;
  std::vector<float> heights;
  for (size_t i = 0; i < points.size(); ++i) {
    if (cells[i].row != kNowhere) heights.push_back(points[i].point_in_world.z());
  }
  const auto middle = heights.begin() + static_cast<ptrdiff_t>(heights.size() / 2);
  std::nth_element(heights.begin(), middle, heights.end());
  const double median = *middle;
  for (size_t i = 0; i < points.size(); ++i) {
    if (std::abs(points[i].point_in_world.z() - median) > max_relief_m) cells[i].row = kNowhere;
  }
}

// The rectangle that holds all cells with points.
cv::Rect PartWithPoints(const std::vector<Cell>& cells) {
  Cell low{std::numeric_limits<int>::max(), std::numeric_limits<int>::max()}, high{-1, -1};
  for (const Cell& cell : cells) {
    if (cell.row == kNowhere) continue;
    low = {std::min(low.row, cell.row), std::min(low.col, cell.col)};
    high = {std::max(high.row, cell.row), std::max(high.col, cell.col)};
  }
  if (high.row < 0) return {};
  return {cv::Point(low.col, low.row), cv::Point(high.col + 1, high.row + 1)};
}

// Ranks by counting the smaller ones; equal heights share the lowest, and fill the gap behind it.
void RankHeights(std::vector<float>& heights) {
  std::array<float, kMaxNumRanked> padded;
  padded.fill(std::numeric_limits<float>::infinity());
  std::copy(heights.begin(), heights.end(), padded.begin());
  std::array<int, kMaxNumRanked> ranks{};
  const size_t num_padded = (heights.size() + 15) / 16 * 16;
  for (size_t j = 0; j < heights.size(); ++j) {
    const float height = padded[j];
    for (size_t i = 0; i < num_padded; ++i) ranks[i] += height < padded[i] ? 1 : 0;
  }
  const float kGap = std::numeric_limits<float>::quiet_NaN();
  std::fill(heights.begin(), heights.end(), kGap);
  for (size_t i = 0; i < heights.size(); ++i) heights[static_cast<size_t>(ranks[i])] = padded[i];
  for (size_t i = 1; i < heights.size(); ++i) {
    if (std::isnan(heights[i])) heights[i] = heights[i - 1];
  }
}

}  // namespace

CellPoints SortIntoCells(const Points& points, const Grid& grid, double max_relief_m) {
  std::vector<Cell> cells = CellsOf(points, grid);
  DropWild(points, max_relief_m, cells);
  CellPoints sorted;
  sorted.cells = PartWithPoints(cells);
  if (sorted.cells.empty()) return sorted;
  // Counting sort; stable.
  const auto index_of = [&sorted](const Cell& cell) {
    return sorted.IndexOf(cell.row - sorted.cells.y, cell.col - sorted.cells.x);
  };
  sorted.start.assign(static_cast<size_t>(sorted.cells.area()) + 1, 0);
  for (const Cell& cell : cells) {
    if (cell.row != kNowhere) ++sorted.start[index_of(cell) + 1];
  }
  for (size_t i = 1; i < sorted.start.size(); ++i) sorted.start[i] += sorted.start[i - 1];
  std::vector<uint32_t> next(sorted.start.begin(), sorted.start.end() - 1);
  sorted.points.resize(sorted.start.back());
  for (size_t i = 0; i < points.size(); ++i) {
    if (cells[i].row != kNowhere) sorted.points[next[index_of(cells[i])]++] = points[i];
  }
  return sorted;
}

void SortHeights(std::vector<float>& heights) {
  if (heights.size() <= kMaxNumRanked) {
    RankHeights(heights);
  } else {
    std::sort(heights.begin(), heights.end());
  }
}

}  // namespace freelsd
