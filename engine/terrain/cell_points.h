// Private to terrain/. The points of a stereo pair, sorted by cell.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/terrain/terrain.h"

namespace freelsd {

struct CellPoints {
  // The part of the grid that holds points: x = col, y = row. Empty if there are no points.
  cv::Rect cells;
  // Row-major by cell. Within a cell, points keep their input order.
  Points points;
  // World z of each point.
  std::vector<float> heights;
  // points[start[i] .. start[i + 1]) lie in cell i of `cells`.
  std::vector<uint32_t> start;

  size_t IndexOf(int row, int col) const { return static_cast<size_t>(row) * cells.width + col; }
};

// Reuses its memory for the next pair, because allocation takes longer than sorting.
class CellSorter {
 public:
  // Drops points outside the grid, points without a known height or deviation, and points farther
  // than max_relief_m from the median height.
  void Sort(const Points& points, const Grid& grid, double max_relief_m);
  // Result of the last call.
  const CellPoints& sorted() const { return sorted_; }
  // Sets the point's height to unknown, so that sums skip it. `heights` keeps the height.
  void ForgetHeight(size_t point);

 private:
  void Locate(const Points& points, const Grid& grid, double max_relief_m);
  void CountPerCell();

  // One value per input point. After Locate: row and column of the point. After CountPerCell: row_
  // is the index of the point's cell in `cells`, and col_ is the number of earlier points in this
  // cell.
  std::vector<int> row_, col_;
  CellPoints sorted_;
};

// Sorts heights in ascending order, in place.
void SortHeights(std::vector<float>& heights);

}  // namespace freelsd
