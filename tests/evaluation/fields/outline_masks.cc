#include "tests/evaluation/fields/outline_masks.h"

#include <cmath>

#include <opencv2/imgproc.hpp>

namespace freelsd {

cv::Mat1b MaskOf(const Polygon& outline, const Grid& grid) {
  std::vector<cv::Point> cells;
  for (const Eigen::Vector2d& corner : outline) {
    const Eigen::Vector2d at = (corner - grid.north_west_in_world) / grid.cell_size_m;
    cells.emplace_back(static_cast<int>(std::floor(at.x())), static_cast<int>(std::floor(-at.y())));
  }
  cv::Mat1b mask = cv::Mat1b::zeros(grid.num_rows, grid.num_cols);
  cv::fillPoly(mask, std::vector<std::vector<cv::Point>>{cells}, cv::Scalar(255));
  return mask;
}

}  // namespace freelsd
