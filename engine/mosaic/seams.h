// Which view shows which seam cell.
#pragma once

#include <functional>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/mosaic/view_layer.h"

namespace freelsd {

// Index of a layer for each seam cell; -1 where no layer offers the cell. Minimises the costs of
// views and seams over the whole mosaic (Boykov, Veksler and Zabih 2001, alpha-expansion). The
// pictures of the layers have their gains.
cv::Mat1s ChooseLayers(const std::vector<ViewLayer>& layers,
                       const LatticeRect& seam_cells,
                       const MosaicOptions& options);

// Mean absolute difference between the mean brightness of both sides of a seam, over all pairs of
// views and weighted by the length of their seam, grey levels.
double MeanStep(const std::vector<ViewLayer>& layers,
                const cv::Mat1s& chosen,
                const LatticeRect& seam_cells,
                const std::function<cv::Vec3d(size_t layer, const cv::Point& cell)>& color_of);

}  // namespace freelsd
