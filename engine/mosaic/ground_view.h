// Where a view's image shows the ground.
#pragma once

#include <opencv2/core.hpp>

#include "engine/adjustment/adjustment.h"
#include "engine/footprint/footprint.h"
#include "engine/mosaic/picture_ground.h"

namespace freelsd {

// Cells of the lattice that touch the footprint.
cv::Rect CellsOf(const Footprint& footprint, const LatticeRect& within);

class GroundView {
 public:
  GroundView(const PictureGround& ground, const AdjustedBlock& block, size_t view);

  const Camera& camera() const { return camera_; }
  const Eigen::Vector3d& position_in_world() const { return position_in_world_; }
  double cell_size_m() const { return ground_.grid().cell_size_m; }
  // Size of a pixel on the ground, metres.
  double SamplingM() const { return sampling_m_; }
  // Part of `within` that the image may show.
  cv::Rect CellsWithin(const LatticeRect& within) const;
  // Image position of the centre of each cell: exact at nodes, which include the centres of the
  // map's cells, and linear between them. kNoPixel where there is no height or no image position.
  // Positions may lie outside the image.
  cv::Mat2f ImageOf(const LatticeRect& rect, double node_spacing_m) const;

 private:
  cv::Vec2f ImageOfNode(const Eigen::Vector2d& place_in_world) const;

  const PictureGround& ground_;
  const Camera camera_;
  const Eigen::Vector3d position_in_world_;
  const Rigid3d camera_from_world_;
  const Footprint footprint_;
  const double sampling_m_;
};

}  // namespace freelsd
