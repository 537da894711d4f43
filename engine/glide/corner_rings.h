// Private to glide/: the edges of areas of cells, exactly.
#pragma once

#include <utility>
#include <vector>

#include <opencv2/core.hpp>

namespace freelsd {

// Corners of cells: x is the column, y the row of the cell that lies south-east of it.
using CornerRing = std::vector<cv::Point>;

// The corners of one area, its outer ring first, then its holes. The area lies to the left of its
// rings, as seen on a map with north up. Only corners where the ring turns.
using CornerRings = std::vector<CornerRing>;

// Clears cells that touch another one at a corner alone, until none do: no corner then belongs to
// two rings, or twice to one.
void ClearTouchingCorners(cv::Mat1b& cells);

// `cells` has no cells that touch at a corner alone.
std::vector<CornerRings> RingsOf(const cv::Mat1b& cells);

}  // namespace freelsd
