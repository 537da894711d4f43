// What one view could contribute to the mosaic, at the size of seam cells.
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "engine/mosaic/ground_view.h"

namespace freelsd {

// Cost of a cell that the view does not show.
constexpr uint8_t kNotShown = 255;

struct ViewLayer {
  // Index into the block's views.
  size_t view = 0;
  // Seam cells of the rasters below.
  cv::Rect cells;
  // Costs of steepness, border and hiding, grey levels, below kNotShown; or kNotShown.
  cv::Mat1b cost;
  // 255 where the view is one of the best.
  cv::Mat1b is_candidate;
  // Mean BGR of the cell.
  cv::Mat3b picture;
  // Mean contrast between neighbouring pixels of the image, in quarters of grey levels.
  cv::Mat1b detail;
  // Cost of the whole view for lack of detail.
  int blur_cost = 0;

  bool Shows(const cv::Point& cell) const {
    return cells.contains(cell) && cost(cell - cells.tl()) != kNotShown;
  }
  bool Offers(const cv::Point& cell) const {
    return cells.contains(cell) && is_candidate(cell - cells.tl()) != 0;
  }
};

// Layers with costs but without pictures, of those connected views that are wanted and may show
// one of the seam cells.
std::vector<ViewLayer> LayersOf(const PictureGround& ground,
                                const AdjustedBlock& block,
                                const LatticeRect& seam_cells,
                                const std::vector<bool>& is_wanted,
                                const MosaicOptions& options);

// Marks the best views of each cell as candidates, drops layers without candidates, and reduces the
// others to the surroundings of their candidates.
std::vector<ViewLayer> WithCandidates(std::vector<ViewLayer> layers,
                                      const LatticeRect& seam_cells,
                                      int margin_cells,
                                      const MosaicOptions& options);

// Adds picture and detail. The image has the camera's size.
void AddPicture(const cv::Mat& image,
                const GroundView& ground_view,
                double seam_cell_size_m,
                ViewLayer& layer);

// Whether the image can be used: 8 bit, BGR or grey, of the camera's size.
bool IsUsable(const cv::Mat& image, const Camera& camera);
cv::Mat3b AsColor(const cv::Mat& image);

}  // namespace freelsd
