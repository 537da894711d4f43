#include "engine/mosaic/picture_ground.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
// Cells beyond shown ground that get a height, because heights are interpolated up to the edge.
constexpr int kNumOuterRings = 2;

cv::Mat1b Seen(const cv::Mat1f& elevation) { return cv::Mat1b(elevation == elevation); }

// Mean of the neighbours that have a height; NaN if none has.
float MeanOfNeighbours(const cv::Mat1f& height, const cv::Point& cell) {
  float sum = 0.0f;
  int count = 0;
  for (int row = std::max(0, cell.y - 1); row <= std::min(height.rows - 1, cell.y + 1); ++row) {
    for (int col = std::max(0, cell.x - 1); col <= std::min(height.cols - 1, cell.x + 1); ++col) {
      if (std::isnan(height(row, col))) continue;
      sum += height(row, col);
      ++count;
    }
  }
  return count == 0 ? kNaN : sum / static_cast<float>(count);
}

// Gives heights to the unknown cells of the mask that touch known ones.
void GrowOnce(const cv::Mat1b& mask, cv::Mat1f& height) {
  std::vector<std::pair<cv::Point, float>> grown;
  for (int row = 0; row < height.rows; ++row) {
    for (int col = 0; col < height.cols; ++col) {
      if (!mask(row, col) || !std::isnan(height(row, col))) continue;
      const float mean = MeanOfNeighbours(height, {col, row});
      if (!std::isnan(mean)) grown.emplace_back(cv::Point(col, row), mean);
    }
  }
  for (const auto& [cell, mean] : grown) height(cell) = mean;
}

// Closes gaps up to `width` cells.
cv::Mat1b Closed(const cv::Mat1b& seen, int width) {
  if (width < 1) return seen.clone();
  const int side = width + 1 - width % 2;
  cv::Mat1b padded, closed;
  cv::copyMakeBorder(seen, padded, side, side, side, side, cv::BORDER_CONSTANT, 0);
  const cv::Mat element = cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side});
  cv::morphologyEx(padded, closed, cv::MORPH_CLOSE, element);
  return closed(cv::Rect(cv::Point(side, side), seen.size())).clone();
}

// Gaussian mean of the known heights; unknown ones stay unknown.
cv::Mat1f Smoothed(const cv::Mat1f& height, double sigma_cells) {
  if (sigma_cells < 0.1) return height;
  const cv::Mat1b known = Seen(height);
  cv::Mat1f sum(height.size(), 0.0f), weight(height.size(), 0.0f);
  height.copyTo(sum, known);
  weight.setTo(1.0f, known);
  cv::GaussianBlur(sum, sum, {}, sigma_cells, sigma_cells, cv::BORDER_CONSTANT);
  cv::GaussianBlur(weight, weight, {}, sigma_cells, sigma_cells, cv::BORDER_CONSTANT);
  cv::Mat1f smoothed(height.size(), kNaN);
  cv::Mat1f(sum / weight).copyTo(smoothed, known);
  return smoothed;
}

}  // namespace

PictureGround::PictureGround(const ElevationMap& map, const MosaicOptions& options)
    : grid_(map.grid), height_(map.elevation.clone()) {
  const cv::Mat1b seen = Seen(map.elevation);
  const int width = static_cast<int>(options.max_hole_m / grid_.cell_size_m);
  is_shown_ = Closed(seen, width);
  for (int i = 0; i <= width; ++i) GrowOnce(is_shown_, height_);
  is_shown_ &= Seen(height_);
  height_ = Smoothed(height_, options.height_smoothing_m / grid_.cell_size_m);
  const cv::Mat1b everywhere(height_.size(), uint8_t{255});
  for (int i = 0; i < kNumOuterRings; ++i) GrowOnce(everywhere, height_);
  cv::minMaxLoc(height_, &lowest_, &highest_, nullptr, nullptr, Seen(height_));
}

float PictureGround::HeightAt(const Eigen::Vector2d& place_in_world) const {
  const double east = (place_in_world.x() - grid_.north_west_in_world.x()) / grid_.cell_size_m;
  const double south = (grid_.north_west_in_world.y() - place_in_world.y()) / grid_.cell_size_m;
  const double x = std::clamp(east - 0.5, 0.0, grid_.num_cols - 1.0);
  const double y = std::clamp(south - 0.5, 0.0, grid_.num_rows - 1.0);
  const int left = static_cast<int>(x), top = static_cast<int>(y);
  const auto u = static_cast<float>(x - left), v = static_cast<float>(y - top);
  // A neighbour without weight may have no height.
  const int right = u > 0.0f ? left + 1 : left, bottom = v > 0.0f ? top + 1 : top;
  const float upper = (1.0f - u) * height_(top, left) + u * height_(top, right);
  const float lower = (1.0f - u) * height_(bottom, left) + u * height_(bottom, right);
  return (1.0f - v) * upper + v * lower;
}

cv::Mat1b PictureGround::ShownCells(const LatticeRect& rect) const {
  std::vector<int> cols(static_cast<size_t>(rect.cells.width));
  for (int col = 0; col < rect.cells.width; ++col) {
    const double east = rect.CellCenter(0, col).x() - grid_.north_west_in_world.x();
    cols[static_cast<size_t>(col)] = static_cast<int>(std::floor(east / grid_.cell_size_m));
  }
  cv::Mat1b shown(rect.cells.size(), uint8_t{0});
  for (int row = 0; row < shown.rows; ++row) {
    const double south = grid_.north_west_in_world.y() - rect.CellCenter(row, 0).y();
    const int map_row = static_cast<int>(std::floor(south / grid_.cell_size_m));
    if (map_row < 0 || map_row >= grid_.num_rows) continue;
    for (int col = 0; col < shown.cols; ++col) {
      const int map_col = cols[static_cast<size_t>(col)];
      if (map_col < 0 || map_col >= grid_.num_cols) continue;
      shown(row, col) = is_shown_(map_row, map_col);
    }
  }
  return shown;
}

}  // namespace freelsd
