#include "engine/hazard/distance_transform.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace freelsd {
namespace {

// Distances up to this many cells are found by trying every column so near; beyond, by an envelope.
constexpr int kNearCells = 48;
// Columns that are worked on together, and steps between tests whether they are done.
constexpr int kBlock = 16;
constexpr int kStepsPerTest = 4;
// Squares of column distances stay whole in a float.
constexpr int kMaxNearRows = 4000;

// Rows to the nearest cell that is not free in the same column; the rows above and below the grid
// are unseen.
cv::Mat1i RowsToHazard(const cv::Mat1b& hazard) {
  cv::Mat1i rows(hazard.size());
  std::vector<int> distance(static_cast<size_t>(hazard.cols), 0);
  for (int row = 0; row < hazard.rows; ++row) {
    const uint8_t* values = hazard[row];
    int* line = rows[row];
    for (int col = 0; col < hazard.cols; ++col) {
      distance[static_cast<size_t>(col)] =
          values[col] == kFree ? distance[static_cast<size_t>(col)] + 1 : 0;
      line[col] = distance[static_cast<size_t>(col)];
    }
  }
  std::fill(distance.begin(), distance.end(), 0);
  for (int row = hazard.rows - 1; row >= 0; --row) {
    int* line = rows[row];
    for (int col = 0; col < hazard.cols; ++col) {
      const int from_south = distance[static_cast<size_t>(col)] + 1;
      line[col] = std::min(line[col], from_south);
      distance[static_cast<size_t>(col)] = line[col];
    }
  }
  return rows;
}

// Squared distances of a row whose cells are all within kNearCells of a hazard, else nothing.
// `squares` holds the squared rows to hazard, with kNearCells columns of 0 before, and as many and
// a block more behind.
bool NearDistances(const std::vector<float>& squares, int num_cols, std::vector<float>& result) {
  for (int first = 0; first < num_cols; first += kBlock) {
    const float* here = squares.data() + kNearCells + first;
    std::array<float, kBlock> best;
    std::copy(here, here + kBlock, best.begin());
    int step = 1;
    while (static_cast<float>(step * step) < *std::max_element(best.begin(), best.end())) {
      if (step > kNearCells) return false;
      for (int end = std::min(step + kStepsPerTest, kNearCells + 1); step < end; ++step) {
        const auto square = static_cast<float>(step * step);
        for (int i = 0; i < kBlock; ++i) {
          const float beside = std::min(here[i - step], here[i + step]) + square;
          best[static_cast<size_t>(i)] = std::min(best[static_cast<size_t>(i)], beside);
        }
      }
    }
    std::copy(best.begin(), best.end(), result.begin() + first);
  }
  return true;
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

float Metres(int64_t squared_cells, double cell_size_m) {
  return static_cast<float>(std::sqrt(static_cast<double>(squared_cells)) * cell_size_m);
}

void WriteFarRow(const int* rows, double cell_size_m, cv::Mat1f line) {
  // One unseen cell on each side, with no height.
  std::vector<int64_t> heights(static_cast<size_t>(line.cols) + 2, 0);
  for (int col = 0; col < line.cols; ++col) {
    heights[col + 1] = static_cast<int64_t>(rows[col]) * rows[col];
  }
  const std::vector<int64_t> squared = SquaredDistances(heights);
  for (int col = 0; col < line.cols; ++col) line(0, col) = Metres(squared[col + 1], cell_size_m);
}

}  // namespace

cv::Mat1f DistanceToHazard(const cv::Mat1b& hazard, double cell_size_m) {
  cv::Mat1f distance(hazard.size());
  const cv::Mat1i rows = RowsToHazard(hazard);
  // No square of a near distance is larger.
  std::vector<float> metres(2 * kNearCells * kNearCells + 1);
  for (size_t i = 0; i < metres.size(); ++i) {
    metres[i] = Metres(static_cast<int64_t>(i), cell_size_m);
  }
  std::vector<float> squares(static_cast<size_t>(hazard.cols) + 2 * kNearCells + kBlock, 0.0f);
  std::vector<float> nearest(static_cast<size_t>(hazard.cols) + kBlock);
  for (int row = 0; row < hazard.rows; ++row) {
    const int* line = rows[row];
    std::transform(line, line + hazard.cols, squares.begin() + kNearCells, [](int height) {
      const int near_height = std::min(height, kMaxNearRows);
      return static_cast<float>(near_height * near_height);
    });
    if (!NearDistances(squares, hazard.cols, nearest)) {
      WriteFarRow(line, cell_size_m, distance.row(row));
      continue;
    }
    std::transform(
        nearest.begin(), nearest.begin() + hazard.cols, distance[row], [&metres](float squared) {
          return metres[static_cast<size_t>(squared)];
        });
  }
  return distance;
}

}  // namespace freelsd
