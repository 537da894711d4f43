// Input: elevation map, adjusted views, images. Output: the ground as photographed, seen from
// straight above, as tiles at the photographs' own ground sampling. Not in the paper.
//
// It is a picture and no claim of safety: small holes of the map are filled in it.
#pragma once

#include <functional>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/adjustment/adjustment.h"
#include "engine/terrain/terrain.h"

namespace freelsd {

struct MosaicOptions {
  // --- What is made ---
  // Smallest pixel on the ground. Photographs that show more detail are averaged.
  double min_pixel_size_m = 0.02;
  // Side of a tile. Must be a power of two, because tiles are halved level by level.
  int tile_size_px = 512;
  // Gaps of the map up to this width get heights from their surroundings. Wider gaps stay
  // transparent.
  double max_hole_m = 5.0;
  // Standard deviation of the Gaussian that smooths heights for the picture. Noise and the steps at
  // crowns bend straight lines and mix up leaves.
  double height_smoothing_m = 1.0;

  // --- Which view shows a place ---
  // Approximate side of the cells for which a view is chosen. The size is rounded to a power of two
  // of pixels.
  double seam_cell_size_m = 0.4;
  // Number of views per cell that are considered: the best by steepness and place in the picture.
  int max_num_candidates = 3;
  // Part of the picture along its border, as a share of its shorter side, that is used
  // reluctantly: lenses are least sharp there and corners darkest.
  double border_ratio = 0.12;
  // Costs of a seam cell, in grey levels. The cost of a view is steepness_cost times the squared
  // tangent of its angle to the vertical, plus up to border_cost, plus blur_cost times the natural
  // logarithm of its lack of detail, plus exposure_cost where it is black or white. The cost of a
  // seam between two cells is seam_cost plus the differences of the two views in both cells.
  double steepness_cost = 100.0;
  double border_cost = 60.0;
  double blur_cost = 80.0;
  double exposure_cost = 40.0;
  double seam_cost = 4.0;
  // Cost of a view in which higher ground hides the place by more than hidden_height_m.
  double hidden_cost = 80.0;
  double hidden_height_m = 1.0;
  // Each round offers every view to every cell once. Rounds end when no cell changes.
  int max_num_rounds = 3;

  // --- Brightness and colour ---
  // Prior deviation of the logarithm of a view's gain. A larger value lets brightness drift along a
  // long flight.
  double gain_sd = 0.15;
  // Brightness and colour that are left after the gains are blended across seams over about twice
  // this distance. Details are not blended: an object never appears twice.
  double blend_radius_m = 4.0;

  // --- Cost ---
  // Decoded images that are kept: those parts of them that the mosaic shows. Does not change the
  // result.
  double max_cache_mb = 200.0;

  // Throws std::invalid_argument: "mosaic.tile_size_px = 100: must be a power of two".
  void Check() const;
};

// Where tiles lie. Tile (level, row, col) covers the world's east in [col, col + 1) * side and its
// south, the negative north, in [row, row + 1) * side, where side = TileSideM(level). Rows count
// southwards from the world origin, as the rows of an image do; tiles north and west of the origin
// have negative numbers. Two mosaics of equal pixel size have the same tiles.
struct MosaicLattice {
  // Of level 0, the finest. A pixel of level l is pixel_size_m * 2^l. The cell size of the map is a
  // whole multiple of pixel_size_m. 0 if there is nothing to show.
  double pixel_size_m = 0.0;
  int tile_size_px = 0;
  // At the last level, the map is not larger than a tile. It may still extend over up to four
  // tiles, because it may lie across their borders.
  int num_levels = 0;
  // Tiles of level 0 that the map touches: x and width are columns, y and height are rows.
  cv::Rect tiles;

  double TileSideM(int level) const { return pixel_size_m * tile_size_px * double(1 << level); }
  // Tiles of a level that the map touches.
  cv::Rect TilesOf(int level) const;
};

// The pixel size is the cell size of the map divided by a whole number, and near the median ground
// sampling of the connected views, at most a few percent finer. Throws std::invalid_argument if the
// map's grid is not aligned to multiples of its cell size.
MosaicLattice PlanMosaic(const ElevationMap& map,
                         const AdjustedBlock& block,
                         const MosaicOptions& options);

struct MosaicTile {
  int level = 0;
  int row = 0;
  int col = 0;
  // BGRA, tile_size_px square, row 0 is the northern edge. Alpha is 0 where no photograph shows the
  // ground, and 255 elsewhere at level 0. At coarser levels it is the share of shown ground.
  cv::Mat4b image;
};

// How the mosaic was put together.
struct MosaicReport {
  MosaicLattice lattice;
  // Cells for which a view was chosen. Row 0 is the northern edge.
  Grid seam_grid;
  // Index into the block's views; -1 where the mosaic is transparent.
  cv::Mat1s view;
  // Factor of blue, green and red, one per view; 1 for a view that is not used. The mean of the
  // logarithms is 0.
  std::vector<cv::Vec3d> gains;
  // Mean difference of brightness between the two sides of seams, grey levels: of the photographs,
  // with gains, and with gains and blending.
  double step_photographed = 0.0;
  double step_with_gains = 0.0;
  double step_blended = 0.0;
  // Views whose image was not available.
  int num_missing_images = 0;
  // Of all levels.
  int num_tiles = 0;
};

// Calls `keep` once for every tile that shows ground. The tiles come in the order of a
// space-filling curve; a coarser tile comes after the four tiles that it consists of. Needs each
// image twice or more. A frame whose image is empty or has another size than the camera is skipped.
// Images are BGR or grey.
//
// Memory besides the input: max_cache_mb; one image and its map of detail; 3 tiles per level; about
// 70 bytes per seam cell (440 MB per square kilometre at 0.4 m). The result does not depend on the
// number of threads or on the order of the tiles.
MosaicReport MakeMosaic(const ElevationMap& map,
                        const AdjustedBlock& block,
                        const ImageSource& images,
                        const MosaicOptions& options,
                        const std::function<void(const MosaicTile&)>& keep);

// Number of connected views whose image shows the centre of each seen cell, at most 255; 0 where
// unseen. Ignores what hides the cell.
cv::Mat1b NumViewsOf(const ElevationMap& map, const AdjustedBlock& block);

}  // namespace freelsd
