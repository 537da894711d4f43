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
  // World z of each of them.
  std::vector<float> heights;
  // points[start[i] .. start[i + 1]) lie in cell i of that part.
  std::vector<uint32_t> start;

  size_t IndexOf(int row, int col) const { return static_cast<size_t>(row) * cells.width + col; }
};

// Keeps its memory from pair to pair: asking the system for it anew takes longer than the sorting.
class CellSorter {
 public:
  // Points outside the grid, those whose height or deviation is not known, and those farther than
  // max_relief_m from the median height are left out.
  void Sort(const Points& points, const Grid& grid, double max_relief_m);
  // Of the last call.
  const CellPoints& sorted() const { return sorted_; }
  // A point without height adds nothing to any sum; `heights` still tells it.
  void ForgetHeight(size_t point);

 private:
  void Locate(const Points& points, const Grid& grid, double max_relief_m);
  void CountPerCell();

  // Of each point, in the order they came in: at first its row and column, then its cell in the
  // part with points and how many came before it there.
  std::vector<int> row_, col_;
  CellPoints sorted_;
};

// Heights in ascending order, in place.
void SortHeights(std::vector<float>& heights);

}  // namespace freelsd
