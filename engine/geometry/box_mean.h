// Means and sums over squares around every cell of a raster.
#pragma once

#include <opencv2/core.hpp>

namespace freelsd {

// The odd number of cells nearest to the width. It is odd so that a square has a middle cell.
int BoxSide(double width_cells);

// Which values are assumed beyond the edge of the raster.
enum class BoxBorder {
  kNothing,   // zeros
  kMirrored,  // the raster, mirrored at the centres of its outermost cells
};

cv::Mat1f BoxMean(const cv::Mat1f& values, int side, BoxBorder border);

// Cells beyond the edge count as 0.
cv::Mat1d BoxSum(const cv::Mat1d& values, int side);

}  // namespace freelsd
