#include "engine/terrain/cell_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/terrain/registers.h"

namespace freelsd {
namespace {

// Row of a dropped point.
constexpr int kNowhere = -1;
// Up to this many heights, comparing all with all is faster than sorting, because it has no branch.
constexpr size_t kMaxNumRanked = 64;
// Number of heights ranked side by side.
constexpr size_t kRankBlock = 16;
constexpr size_t kMaxLanes = 8;

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
};

// Rows and columns of the points, and the range of heights of those inside the grid.
template <size_t num_lanes>
[[gnu::always_inline]] inline Range LocateAll(
    const DensePoint* points, size_t num_points, const Grid& grid, int* rows, int* cols) {
  using Doubles = typename Register<num_lanes>::Doubles;
  const Doubles zero{}, nowhere = zero + kNowhere;
  const double west = grid.north_west_in_world.x(), north = grid.north_west_in_world.y();
  const double per_cell = 1.0 / grid.cell_size_m;
  const double num_rows = grid.num_rows, num_cols = grid.num_cols;
  Doubles lows = zero + Range{}.low, highs = zero + Range{}.high;
  for (size_t i = 0; i < num_points; i += num_lanes) {
    // Repeats the last points instead of reading past the end.
    const size_t first = std::min(i, num_points - num_lanes);
    Doubles x, y, z, deviation;
    for (size_t lane = 0; lane < num_lanes; ++lane) {
      x[lane] = points[first + lane].point_in_world[0];
      y[lane] = points[first + lane].point_in_world[1];
      z[lane] = points[first + lane].point_in_world[2];
      deviation[lane] = points[first + lane].height_sd_m;
    }
    const Doubles u = (x - west) * per_cell, v = (north - y) * per_cell;
    const auto is_inside = (u >= 0.0) & (v >= 0.0) & (u < num_cols) & (v < num_rows) &
                           (deviation >= 0.0) & (z - z == 0.0) & (deviation - deviation == 0.0);
    typename Register<num_lanes>::Ints row, col;
    Convert(is_inside ? v : nowhere, row);
    Convert(is_inside ? u : nowhere, col);
    Store(row, rows + first);
    Store(col, cols + first);
    lows = (is_inside & (z < lows)) ? z : lows;
    highs = (is_inside & (z > highs)) ? z : highs;
  }
  Range range;
  for (size_t lane = 0; lane < num_lanes; ++lane) {
    range = {std::min(range.low, lows[lane]), std::max(range.high, highs[lane])};
  }
  return range;
}

// For each height, the number of smaller heights. Infinity must follow the last height up to a
// whole block.
template <size_t num_lanes>
[[gnu::always_inline]] inline void RankAll(const float* heights, size_t num_heights, int* ranks) {
  constexpr size_t kNumRegisters = kRankBlock / num_lanes;
  for (size_t block = 0; block < num_heights; block += kRankBlock) {
    typename Register<num_lanes>::Floats own[kNumRegisters];
    typename Register<num_lanes>::Ints num_less[kNumRegisters] = {};
    for (size_t k = 0; k < kNumRegisters; ++k) Load(heights + block + k * num_lanes, own[k]);
    for (size_t i = 0; i < num_heights; ++i) {
      // True is -1 in every lane.
      for (size_t k = 0; k < kNumRegisters; ++k) num_less[k] -= heights[i] < own[k];
    }
    for (size_t k = 0; k < kNumRegisters; ++k) Store(num_less[k], ranks + block + k * num_lanes);
  }
}

struct Kernels {
  Range (*locate)(const DensePoint*, size_t, const Grid&, int*, int*);
  void (*rank)(const float*, size_t, int*);
};

Range LocatePlain(const DensePoint* points, size_t count, const Grid& grid, int* rows, int* cols) {
  return LocateAll<2>(points, count, grid, rows, cols);
}
void RankPlain(const float* heights, size_t num_heights, int* ranks) {
  RankAll<4>(heights, num_heights, ranks);
}

#if defined(__x86_64__)
// No fused multiplications, so that every processor rounds alike.
[[gnu::target("avx2")]] Range LocateAvx2(
    const DensePoint* points, size_t count, const Grid& grid, int* rows, int* cols) {
  return LocateAll<4>(points, count, grid, rows, cols);
}
[[gnu::target("avx2")]] void RankAvx2(const float* heights, size_t num_heights, int* ranks) {
  RankAll<8>(heights, num_heights, ranks);
}

Kernels FastestKernels() {
  if (__builtin_cpu_supports("avx2") != 0) return {LocateAvx2, RankAvx2};
  return {LocatePlain, RankPlain};
}
#else
Kernels FastestKernels() { return {LocatePlain, RankPlain}; }
#endif

// Equal heights share the lowest rank and fill the gap behind it.
void RankHeights(std::vector<float>& heights) {
  static const auto kRank = FastestKernels().rank;
  std::array<float, kMaxNumRanked> padded;
  std::array<int, kMaxNumRanked> ranks;
  std::copy(heights.begin(), heights.end(), padded.begin());
  const size_t num_padded = (heights.size() + kRankBlock - 1) / kRankBlock * kRankBlock;
  std::fill(padded.begin() + static_cast<ptrdiff_t>(heights.size()),
            padded.begin() + static_cast<ptrdiff_t>(num_padded),
            std::numeric_limits<float>::infinity());
  kRank(padded.data(), heights.size(), ranks.data());
  const float gap = std::numeric_limits<float>::quiet_NaN();
  std::fill(heights.begin(), heights.end(), gap);
  for (size_t i = 0; i < heights.size(); ++i) heights[static_cast<size_t>(ranks[i])] = padded[i];
  for (size_t i = 1; i < heights.size(); ++i) {
    if (std::isnan(heights[i])) heights[i] = heights[i - 1];
  }
}

// Sets the row of points farther than max_relief_m from the median height to kNowhere.
void DropWild(const Points& points, double max_relief_m, std::vector<int>& rows) {
  std::vector<float> heights;
  for (size_t i = 0; i < points.size(); ++i) {
    if (rows[i] != kNowhere) heights.push_back(points[i].point_in_world.z());
  }
  const auto middle = heights.begin() + static_cast<ptrdiff_t>(heights.size() / 2);
  std::nth_element(heights.begin(), middle, heights.end());
  const double median = *middle;
  for (size_t i = 0; i < points.size(); ++i) {
    if (std::abs(points[i].point_in_world.z() - median) > max_relief_m) rows[i] = kNowhere;
  }
}

// The rectangle that holds all cells with points.
cv::Rect PartWithPoints(const std::vector<int>& rows, const std::vector<int>& cols) {
  cv::Point low(std::numeric_limits<int>::max(), std::numeric_limits<int>::max()), high(-1, -1);
  for (size_t i = 0; i < rows.size(); ++i) {
    const bool is_somewhere = rows[i] != kNowhere;
    low.y = std::min(low.y, is_somewhere ? rows[i] : low.y);
    low.x = std::min(low.x, is_somewhere ? cols[i] : low.x);
    high.y = std::max(high.y, is_somewhere ? rows[i] : high.y);
    high.x = std::max(high.x, is_somewhere ? cols[i] : high.x);
  }
  if (high.y < 0) return {};
  return {low, cv::Point(high.x + 1, high.y + 1)};
}

}  // namespace

void CellSorter::Locate(const Points& points, const Grid& grid, double max_relief_m) {
  static const auto kLocate = FastestKernels().locate;
  row_.resize(std::max(points.size(), kMaxLanes));
  col_.resize(row_.size());
  Range range;
  if (points.size() >= kMaxLanes) {
    range = kLocate(points.data(), points.size(), grid, row_.data(), col_.data());
  } else {
    Points padded(kMaxLanes, {Eigen::Vector3f::Zero(), std::numeric_limits<float>::quiet_NaN()});
    std::copy(points.begin(), points.end(), padded.begin());
    range = kLocate(padded.data(), padded.size(), grid, row_.data(), col_.data());
  }
  row_.resize(points.size());
  col_.resize(points.size());
  // If the range is this narrow, no point can be farther from the median.
  if (range.high - range.low > max_relief_m) DropWild(points, max_relief_m, row_);
}

void CellSorter::CountPerCell() {
  std::vector<uint32_t>& counts = sorted_.start;
  counts.assign(static_cast<size_t>(sorted_.cells.area()) + 1, 0);
  for (size_t i = 0; i < row_.size(); ++i) {
    if (row_[i] == kNowhere) continue;
    const size_t cell = sorted_.IndexOf(row_[i] - sorted_.cells.y, col_[i] - sorted_.cells.x);
    row_[i] = static_cast<int>(cell);
    col_[i] = static_cast<int>(counts[cell]++);
  }
}

// Counting sort; stable.
void CellSorter::Sort(const Points& points, const Grid& grid, double max_relief_m) {
  Locate(points, grid, max_relief_m);
  sorted_.cells = PartWithPoints(row_, col_);
  CountPerCell();
  uint32_t num_before = 0;
  for (uint32_t& start : sorted_.start) num_before += std::exchange(start, num_before);
  sorted_.points.resize(num_before);
  sorted_.heights.resize(num_before);
  for (size_t i = 0; i < points.size(); ++i) {
    if (row_[i] == kNowhere) continue;
    const size_t to = sorted_.start[static_cast<size_t>(row_[i])] + static_cast<size_t>(col_[i]);
    sorted_.points[to] = points[i];
    sorted_.heights[to] = points[i].point_in_world.z();
  }
}

void CellSorter::ForgetHeight(size_t point) {
  sorted_.points[point].point_in_world.z() = std::numeric_limits<float>::quiet_NaN();
}

void SortHeights(std::vector<float>& heights) {
  if (heights.size() <= kMaxNumRanked) {
    RankHeights(heights);
  } else {
    std::sort(heights.begin(), heights.end());
  }
}

}  // namespace freelsd
