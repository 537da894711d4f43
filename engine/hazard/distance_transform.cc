#include "engine/hazard/distance_transform.h"

#include <cmath>
#include <vector>

namespace freelsd {
namespace {

// Rows to the nearest cell that is not free in the same column; the rows above and below the grid
// are unseen.
cv::Mat1i RowsToHazard(const cv::Mat1b& hazard) {
  cv::Mat1i rows(hazard.size());
  for (int col = 0; col < hazard.cols; ++col) {
    int distance = 0;
    for (int row = 0; row < hazard.rows; ++row) {
      distance = hazard(row, col) == kFree ? distance + 1 : 0;
      rows(row, col) = distance;
    }
    distance = 0;
    for (int row = hazard.rows - 1; row >= 0; --row) {
      distance = hazard(row, col) == kFree ? distance + 1 : 0;
      rows(row, col) = std::min(rows(row, col), distance);
    }
  }
  return rows;
}

// One parabola (x - col)^2 + height of the lower envelope, lowest from `from` on.
struct Parabola {
  int64_t col;
  int64_t height;
  int64_t from;
};

int64_t FloorDivide(int64_t a, int64_t b) { return a >= 0 ? a / b : -((-a + b - 1) / b); }

// Lower envelope over a row in whole numbers (Meijster et al. 2000): no rounding anywhere.
std::vector<int64_t> SquaredDistances(const std::vector<int64_t>& heights) {
  const auto num_cols = static_cast<int64_t>(heights.size());
  std::vector<Parabola> envelope;
  for (int64_t col = 0; col < num_cols; ++col) {
    int64_t from = 0;
    while (!envelope.empty()) {
      const Parabola& last = envelope.back();
      // The new parabola is lower from the first whole x after the crossing on.
      const int64_t rise = col * col - last.col * last.col + heights[col] - last.height;
      from = FloorDivide(rise, 2 * (col - last.col)) + 1;
      if (from > last.from) break;
      envelope.pop_back();
      from = 0;
    }
    if (envelope.empty() || from < num_cols) envelope.push_back({col, heights[col], from});
  }
  std::vector<int64_t> squared(heights.size());
  size_t current = 0;
  for (int64_t x = 0; x < num_cols; ++x) {
    while (current + 1 < envelope.size() && envelope[current + 1].from <= x) ++current;
    const int64_t step = x - envelope[current].col;
    squared[x] = step * step + envelope[current].height;
  }
  return squared;
}

}  // namespace

cv::Mat1f DistanceToHazard(const cv::Mat1b& hazard, double cell_size_m) {
  cv::Mat1f distance(hazard.size());
  const cv::Mat1i rows = RowsToHazard(hazard);
  // One unseen cell on each side, with no height.
  std::vector<int64_t> heights(static_cast<size_t>(hazard.cols) + 2, 0);
  for (int row = 0; row < hazard.rows; ++row) {
    for (int col = 0; col < hazard.cols; ++col) {
      heights[col + 1] = static_cast<int64_t>(rows(row, col)) * rows(row, col);
    }
    const std::vector<int64_t> squared = SquaredDistances(heights);
    for (int col = 0; col < hazard.cols; ++col) {
      const double cells = std::sqrt(static_cast<double>(squared[col + 1]));
      distance(row, col) = static_cast<float>(cells * cell_size_m);
    }
  }
  return distance;
}

}  // namespace freelsd
