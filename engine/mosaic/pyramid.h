// Tiles of all levels, from those of the finest.
#pragma once

#include <functional>

#include <opencv2/core.hpp>

#include "engine/mosaic/mosaic.h"

namespace freelsd {

// Mean of each 2x2 pixels, weighted by alpha; alpha is the mean. `quarters` are the four tiles
// below in row order; empty ones are transparent. Empty if all are empty.
cv::Mat4b HalvedTile(const cv::Mat4b (&quarters)[4], int tile_size_px);

// Paints each tile of level 0 once, in the order of a Hilbert curve, so that neighbours follow each
// other; up to four at once. `paint` returns an empty image where nothing is shown. Returns the
// number of tiles kept.
int BuildPyramid(const MosaicLattice& lattice,
                 const std::function<cv::Mat4b(int row, int col)>& paint,
                 const std::function<void(const MosaicTile&)>& keep);

}  // namespace freelsd
