#include "engine/cover/overreach.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "engine/cover/photo_features.h"
#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

// A cell with a lower posterior counts as other ground.
constexpr float kMaxOtherPosterior = 0.5f;
// With less area around a cell, the colour is unknown.
constexpr double kMinAreaM2 = 100.0;
// Cells dropped in one round do not count as grass in the next.
constexpr int kNumRounds = 4;
// Narrower strips are a blur of two colours.
constexpr double kMinWidthM = 5.0;
// Rows processed at once. Bounds working memory on large maps.
constexpr int kNumBandRows = 128;

// Colour of a mask's cells within a square around each cell.
struct LocalColor {
  cv::Mat1d num_cells;
  std::array<cv::Mat1d, 3> mean;
  std::array<cv::Mat1d, 3> variance;
};

LocalColor ColorsAround(const cv::Mat1b& mask, const ColorPlanes& colors, int side) {
  cv::Mat1d weight;
  mask.convertTo(weight, CV_64F, 1.0 / 255.0);
  LocalColor local;
  local.num_cells = BoxSum(weight, side);
  const cv::Mat1d divisor = cv::max(local.num_cells, 1.0);
  for (size_t i = 0; i < 3; ++i) {
    cv::Mat1d color;
    colors[i].convertTo(color, CV_64F);
    color.setTo(0.0, mask == 0);
    local.mean[i] = BoxSum(color, side) / divisor;
    local.variance[i] = BoxSum(color.mul(color), side) / divisor - local.mean[i].mul(local.mean[i]);
  }
  return local;
}

// Whether the colour is nearer to `other` than to `grass`. False unless both are known and differ.
bool IsOther(const LocalColor& grass,
             const LocalColor& other,
             const ColorPlanes& colors,
             const cv::Point& cell,
             double min_num_cells,
             double min_separation) {
  if (std::min(grass.num_cells(cell), other.num_cells(cell)) < min_num_cells) return false;
  double separation = 0.0, position = 0.0;
  for (size_t i = 0; i < 3; ++i) {
    const double least = kLeastColorDeviation[i];
    const double variance =
        std::max(0.5 * (grass.variance[i](cell) + other.variance[i](cell)), least * least);
    const double apart = other.mean[i](cell) - grass.mean[i](cell);
    separation += apart * apart / variance;
    position += apart * (colors[i](cell) - grass.mean[i](cell)) / variance;
  }
  return separation > min_separation * min_separation && position > 0.5 * separation;
}

// The ellipse is odd, because OpenCV's opening shifts the result of an even one.
cv::Mat1b Opened(const cv::Mat1b& cells, double width_m, double cell_size_m) {
  const int half = static_cast<int>(std::lround(0.5 * (width_m / cell_size_m - 1.0)));
  const int side = 2 * std::max(0, half) + 1;
  cv::Mat1b opened;
  cv::morphologyEx(
      cells, opened, cv::MORPH_OPEN, cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side}));
  return opened;
}

// The surroundings in which local colours are taken.
struct Neighbourhood {
  int side_cells = 1;
  double min_num_cells = 1.0;
};

// Cells of grass in these rows that have the colour of other ground. Reads only the rows around
// them.
cv::Mat1b MovedIn(const cv::Range& rows,
                  const cv::Mat1b& all_grass,
                  const cv::Mat1b& all_other,
                  const ColorPlanes& colors,
                  const Neighbourhood& surroundings,
                  double min_separation) {
  const int side = surroundings.side_cells;
  const cv::Range around(std::max(0, rows.start - side / 2),
                         std::min(all_other.rows, rows.end + side / 2));
  cv::Mat1b found(rows.size(), all_other.cols, uint8_t{0});
  const cv::Mat1b other = all_other.rowRange(around);
  const cv::Mat1b grass = all_grass.rowRange(around);
  if (cv::countNonZero(other) == 0 || cv::countNonZero(grass) == 0) return found;
  ColorPlanes planes;
  for (size_t i = 0; i < planes.size(); ++i) planes[i] = colors[i].rowRange(around);
  const LocalColor of_grass = ColorsAround(grass, planes, side);
  const LocalColor of_other = ColorsAround(other, planes, side);
  for (int row = 0; row < found.rows; ++row) {
    for (int col = 0; col < found.cols; ++col) {
      const cv::Point cell(col, row + rows.start - around.start);
      const bool is_other =
          grass(cell) &&
          IsOther(of_grass, of_other, planes, cell, surroundings.min_num_cells, min_separation);
      if (is_other) found(row, col) = 255;
    }
  }
  return found;
}

}  // namespace

cv::Mat1b OverreachingGrass(const cv::Mat1f& grass,
                            const Orthophoto& photo,
                            const Grid& grid,
                            const CoverOptions& options) {
  const ColorsOnMap on_map = ColorsOfMap(photo, grid);
  const double cell_m = grid.cell_size_m;
  const Neighbourhood surroundings{BoxSide(2.0 * options.overreach_surroundings_m / cell_m),
                                   kMinAreaM2 / (cell_m * cell_m)};
  const cv::Mat1b is_grass = (grass >= options.min_grass_posterior) & on_map.is_seen;
  // Narrow objects in a meadow do not count as other ground.
  const cv::Mat1b told = Opened((grass < kMaxOtherPosterior) & on_map.is_seen, kMinWidthM, cell_m);
  cv::Mat1b moved = cv::Mat1b::zeros(grass.size());
  for (int round = 0; round < kNumRounds; ++round) {
    const cv::Mat1b staying = is_grass & ~moved;
    cv::Mat1b found(grass.size());
    for (int first = 0; first < grass.rows; first += kNumBandRows) {
      const cv::Range rows(first, std::min(grass.rows, first + kNumBandRows));
      MovedIn(rows, staying, told, on_map.colors, surroundings, options.min_overreach_deviations)
          .copyTo(found.rowRange(rows));
    }
    if (cv::countNonZero(found) == 0) break;
    moved |= found;
  }
  return Opened(moved | told, kMinWidthM, cell_m) & is_grass;
}

}  // namespace freelsd
