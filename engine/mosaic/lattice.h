// Cells of any size that tile the world from its origin, and rectangles of them.
#pragma once

#include <opencv2/core.hpp>

#include "engine/mosaic/mosaic.h"

namespace freelsd {

// Cell (col, row) covers the world's east in [col, col + 1) * size_m and its south, the negative
// north, in [row, row + 1) * size_m. x and width of the rectangle are columns, y and height rows.
struct LatticeRect {
  double size_m = 1.0;
  cv::Rect cells;

  Eigen::Vector2d CellCenter(int row, int col) const {
    return Eigen::Vector2d(cells.x + col + 0.5, -(cells.y + row + 0.5)) * size_m;
  }
};

int FloorDivide(int numerator, int positive_denominator);

// Cells `factor` times as large that touch the given ones.
cv::Rect Coarser(const cv::Rect& cells, int factor);
cv::Rect Finer(const cv::Rect& cells, int factor);
cv::Rect Widened(const cv::Rect& cells, int margin);

// Pixels of level 0 that the map covers.
cv::Rect PixelsOf(const Grid& grid, double pixel_size_m);

// Pixels along the side of a seam cell: a power of two.
int PixelsPerSeamCell(const MosaicLattice& lattice, const MosaicOptions& options);

// The part `wanted` of a raster over the cells `given`; beyond them, its edge repeats.
cv::Mat Part(const cv::Mat& raster, const cv::Rect& given, const cv::Rect& wanted);

// Values at the centres of cells `factor` times as fine, bilinear between the centres of the
// coarse ones. `fine` are fine cells, and the result has their size.
cv::Mat Refined(const cv::Mat& raster, const cv::Rect& coarse, int factor, const cv::Rect& fine);

}  // namespace freelsd
