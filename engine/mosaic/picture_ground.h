// Heights of the ground for the picture: the map's, smoothed, and those of its small holes.
#pragma once

#include <opencv2/core.hpp>

#include "engine/mosaic/lattice.h"
#include "engine/terrain/terrain.h"

namespace freelsd {

class PictureGround {
 public:
  PictureGround(const ElevationMap& map, const MosaicOptions& options);

  const Grid& grid() const { return grid_; }
  double LowestHeight() const { return lowest_; }
  double HighestHeight() const { return highest_; }
  // Bilinear between the centres of cells, metres above the world origin. NaN farther than two
  // cells from shown ground. Beyond the grid, its edge repeats.
  float HeightAt(const Eigen::Vector2d& place_in_world) const;
  // 255 where the centre of the lattice's cell lies in a map cell that is seen or a small hole.
  cv::Mat1b ShownCells(const LatticeRect& rect) const;

 private:
  Grid grid_;
  cv::Mat1f height_;
  cv::Mat1b is_shown_;
  double lowest_ = 0.0;
  double highest_ = 0.0;
};

}  // namespace freelsd
