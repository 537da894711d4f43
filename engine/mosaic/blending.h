// Factors that remove from each layer what differs slowly from its neighbours across seams.
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "engine/mosaic/view_layer.h"

namespace freelsd {

// Seam cells along the side of a cell of the band rasters.
constexpr int kSeamCellsPerBandCell = 4;

// Of one layer: the blended slow part of the mosaic divided by the slow part of the layer.
struct BlendFactors {
  // Band cells of the raster.
  cv::Rect cells;
  // Blue, green, red.
  cv::Mat3f factors;
};

// The slow part of a raster is its Gaussian mean. The blended slow part is the mean of the layers'
// slow parts, weighted by the Gaussian mean of where each layer is chosen (a two-band form of Burt
// and Adelson 1983). The pictures of the layers have their gains.
std::vector<BlendFactors> BlendLayers(const std::vector<ViewLayer>& layers,
                                      const cv::Mat1s& chosen,
                                      const LatticeRect& seam_cells,
                                      double blend_radius_m);

// Multiplies the layers' pictures by their factors.
std::vector<ViewLayer> Blended(std::vector<ViewLayer> layers,
                               const std::vector<BlendFactors>& factors);

}  // namespace freelsd
