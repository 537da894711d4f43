// Input: a raster of heights with holes. Output: a height everywhere.
#pragma once

#include "engine/terrain/terrain.h"

namespace freelsd {

// Between cell centres bilinear. Unseen cells have the height of the nearest seen one. Without any
// seen cell all heights are 0.
class GroundHeights {
 public:
  // `heights`: world z, on the grid; NaN where unseen.
  GroundHeights(const Grid& grid, const cv::Mat1f& heights);
  double At(const Eigen::Vector2d& place_in_world) const;
  // Of the seen cells.
  double median() const { return median_; }

 private:
  Grid grid_;
  double median_ = 0.0;
  cv::Mat1f filled_;
};

}  // namespace freelsd
