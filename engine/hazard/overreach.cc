#include "engine/hazard/overreach.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "engine/hazard/photo_features.h"

namespace freelsd {
namespace {

// Below, a cell is told to be no grass.
constexpr float kMaxOtherPosterior = 0.5f;
// No ground is more even: two shares of colour, logarithm of brightness.
constexpr std::array<double, 3> kLeastDeviation{0.006, 0.006, 0.02};
// Less around a cell has no colour of its own.
constexpr double kMinAreaM2 = 100.0;
// What one round moves has no part in the grass's colour of the next.
constexpr int kNumRounds = 4;
// Narrower is a blur of two colours, not ground.
constexpr double kMinWidthM = 5.0;

// Of a mask's cells within a square around each cell.
struct LocalColor {
  cv::Mat1d num_cells;
  std::array<cv::Mat1d, 3> mean;
  std::array<cv::Mat1d, 3> variance;
};

LocalColor ColorsAround(const cv::Mat1b& mask, const ColorPlanes& colors, int side) {
  const auto sum_of = [&](const cv::Mat1d& values) {
    cv::Mat1d sum;
    cv::boxFilter(values, sum, CV_64F, {side, side}, {-1, -1}, false, cv::BORDER_CONSTANT);
    return sum;
  };
  cv::Mat1d weight;
  mask.convertTo(weight, CV_64F, 1.0 / 255.0);
  LocalColor local;
  local.num_cells = sum_of(weight);
  const cv::Mat1d divisor = cv::max(local.num_cells, 1.0);
  for (size_t i = 0; i < 3; ++i) {
    cv::Mat1d color;
    colors[i].convertTo(color, CV_64F);
    color.setTo(0.0, mask == 0);
    local.mean[i] = sum_of(color) / divisor;
    local.variance[i] = sum_of(color.mul(color)) / divisor - local.mean[i].mul(local.mean[i]);
  }
  return local;
}

// Nearer to `other` than to `grass`, where both are known and apart.
bool IsOther(const LocalColor& grass,
             const LocalColor& other,
             const ColorPlanes& colors,
             const cv::Point& cell,
             double min_num_cells,
             double min_separation) {
  if (std::min(grass.num_cells(cell), other.num_cells(cell)) < min_num_cells) return false;
  double separation = 0.0, position = 0.0;
  for (size_t i = 0; i < 3; ++i) {
    const double variance = std::max(0.5 * (grass.variance[i](cell) + other.variance[i](cell)),
                                     kLeastDeviation[i] * kLeastDeviation[i]);
    const double apart = other.mean[i](cell) - grass.mean[i](cell);
    separation += apart * apart / variance;
    position += apart * (colors[i](cell) - grass.mean[i](cell)) / variance;
  }
  return separation > min_separation * min_separation && position > 0.5 * separation;
}

cv::Mat1b Opened(const cv::Mat1b& cells, int side) {
  cv::Mat1b opened;
  cv::morphologyEx(
      cells, opened, cv::MORPH_OPEN, cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side}));
  return opened;
}

}  // namespace

cv::Mat1b OverreachingGrass(const cv::Mat1f& grass,
                            const Orthophoto& photo,
                            const Grid& grid,
                            const HazardOptions& options) {
  const ColorsOnMap on_map = ColorsOfMap(photo, grid);
  const int width = std::max(1, static_cast<int>(std::lround(kMinWidthM / grid.cell_size_m)));
  const int side = 2 * static_cast<int>(options.overreach_surroundings_m / grid.cell_size_m) + 1;
  const double min_num_cells = kMinAreaM2 / (grid.cell_size_m * grid.cell_size_m);
  const cv::Mat1b is_grass = (grass >= options.min_grass_posterior) & on_map.is_seen;
  // Things that stand in a meadow are not what lies beside it.
  const cv::Mat1b told = Opened((grass < kMaxOtherPosterior) & on_map.is_seen, width);
  cv::Mat1b moved = cv::Mat1b::zeros(grass.size());
  const LocalColor of_other = ColorsAround(told, on_map.colors, side);
  for (int round = 0; round < kNumRounds; ++round) {
    const LocalColor of_grass = ColorsAround(is_grass & ~moved, on_map.colors, side);
    for (int row = 0; row < moved.rows; ++row) {
      for (int col = 0; col < moved.cols; ++col) {
        const cv::Point cell(col, row);
        if (!is_grass(cell) || moved(cell)) continue;
        if (IsOther(of_grass,
                    of_other,
                    on_map.colors,
                    cell,
                    min_num_cells,
                    options.min_overreach_separation)) {
          moved(cell) = 255;
        }
      }
    }
  }
  return Opened(moved | told, width) & is_grass;
}

}  // namespace freelsd
