// Paints tiles of the finest level.
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "engine/mosaic/blending.h"
#include "engine/mosaic/image_cache.h"
#include "engine/mosaic/view_layer.h"

namespace freelsd {

// What is decided before tiles are painted.
struct MosaicDesign {
  MosaicLattice lattice;
  LatticeRect seam_cells;
  int pixels_per_seam_cell = 1;
  // Index of a layer per seam cell; -1 for none.
  cv::Mat1s chosen;
  // Of each layer: its view, and the factors of its colours.
  std::vector<size_t> views;
  std::vector<BlendFactors> factors;
};

class TilePainter {
 public:
  TilePainter(const MosaicDesign& design,
              const PictureGround& ground,
              const AdjustedBlock& block,
              const ImageSource& images,
              double max_cache_mb);

  // Empty if nothing is shown.
  cv::Mat4b Paint(int row, int col);

 private:
  // Adds a layer's weighted colours, and its weights. `chosen` are the seam cells around the tile.
  void AddLayer(size_t layer,
                const cv::Mat1s& chosen,
                const LatticeRect& tile,
                cv::Mat3f& sum,
                cv::Mat1f& sum_of_weights);

  const MosaicDesign& design_;
  const PictureGround& ground_;
  std::vector<GroundView> ground_views_;
  ImageCache cache_;
};

}  // namespace freelsd
