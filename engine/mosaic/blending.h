// Factors that remove from each layer what differs slowly from its neighbours across seams.
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "engine/mosaic/view_layer.h"

namespace freelsd {

// Seam cells along the side of a cell of the band rasters.
constexpr int kSeamCellsPerBandCell = 4;

// Factors of one layer's colours.
struct BlendFactors {
  // Band cells of the raster.
  cv::Rect cells;
  // Blue, green, red.
  cv::Mat3f factors;
};

// The slow part of a raster is its Gaussian mean. The blended slow part is the mean of the layers'
// slow parts, weighted by the Gaussian mean of where each layer is chosen (a two-band form of Burt
// and Adelson 1983). A factor is the blended slow part divided by the layer's. The pictures of the
// layers have their gains.
std::vector<BlendFactors> BlendLayers(const std::vector<ViewLayer>& layers,
                                      const cv::Mat1s& chosen,
                                      const LatticeRect& seam_cells,
                                      double blend_radius_m);

// The factor at a seam cell, by the nearest band cell.
cv::Vec3f FactorAt(const BlendFactors& factors, const cv::Point& seam_cell);

}  // namespace freelsd
