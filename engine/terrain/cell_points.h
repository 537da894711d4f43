// Private to terrain/. The points of a pair, cell by cell.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/terrain/terrain.h"

namespace freelsd {

struct CellPoints {
  // The part of the grid that has points: x = col, y = row. Empty where there are none.
  cv::Rect cells;
  // Row-major by cell; within a cell in the order they came in.
  Points points;
  // points[start[i] .. start[i + 1]) lie in cell i of that part.
  std::vector<uint32_t> start;

  size_t IndexOf(int row, int col) const { return static_cast<size_t>(row) * cells.width + col; }
};

// Points outside the grid, those whose height or deviation is not known, and those farther than
// max_relief_m from the median height are left out.
CellPoints SortIntoCells(const Points& points, const Grid& grid, double max_relief_m);

// Heights in ascending order, in place.
void SortHeights(std::vector<float>& heights);

}  // namespace freelsd
