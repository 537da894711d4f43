#include "engine/heights/proposal_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// Takes single outliers away before the lower envelope would follow them down.
constexpr int kMedianSide = 5;

cv::Mat1b IsKnown(const cv::Mat1f& raster) { return raster == raster; }

// Unknown cells take the mean of the known cells within the window.
cv::Mat1f Filled(const cv::Mat1f& heights, int side) {
  const cv::Mat1b is_known = IsKnown(heights);
  cv::Mat1f weight, sum = heights.clone();
  is_known.convertTo(weight, CV_32F, 1.0 / 255.0);
  sum.setTo(0.0f, ~is_known);
  sum = BoxMean(sum, side, BoxBorder::kNothing);
  weight = BoxMean(weight, side, BoxBorder::kNothing);
  cv::Mat1f filled = heights.clone();
  for (int row = 0; row < filled.rows; ++row) {
    for (int col = 0; col < filled.cols; ++col) {
      if (is_known(row, col) != 0) continue;
      // Less than one cell in the window: rounding of the running sums.
      const bool has_neighbours = weight(row, col) * side * side > 0.5f;
      filled(row, col) = has_neighbours ? sum(row, col) / weight(row, col)
                                        : std::numeric_limits<float>::quiet_NaN();
    }
  }
  return filled;
}

}  // namespace

ProposalSurface::ProposalSurface(const ElevationMap& map, double window_m) {
  if (map.elevation.empty()) return;
  const int side = BoxSide(window_m / map.grid.cell_size_m);
  height_ = Filled(map.elevation, side);
  const cv::Mat1b is_unknown = ~IsKnown(height_);
  double highest = 0.0;
  cv::minMaxLoc(height_, nullptr, &highest, nullptr, nullptr, ~is_unknown);
  // Filters compare: they must meet a number.
  height_.setTo(highest, is_unknown);
  cv::medianBlur(height_, height_, kMedianSide);
  const cv::Mat window = cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side});
  cv::morphologyEx(height_, height_, cv::MORPH_OPEN, window);
  cv::blur(height_, height_, {3, 3});
  height_.setTo(std::numeric_limits<float>::quiet_NaN(), is_unknown);
}

double ProposalSurface::At(double row, double col) const {
  const double v = std::clamp(row, 0.0, height_.rows - 1.0);
  const double u = std::clamp(col, 0.0, height_.cols - 1.0);
  const int top = std::min(static_cast<int>(v), std::max(0, height_.rows - 2));
  const int left = std::min(static_cast<int>(u), std::max(0, height_.cols - 2));
  const int bottom = std::min(top + 1, height_.rows - 1);
  const int right = std::min(left + 1, height_.cols - 1);
  const double down = v - top, along = u - left;
  return (1.0 - down) * ((1.0 - along) * height_(top, left) + along * height_(top, right)) +
         down * ((1.0 - along) * height_(bottom, left) + along * height_(bottom, right));
}

}  // namespace freelsd
