#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "engine/terrain/terrain.h"

namespace freelsd {
namespace {

// Tolerance for corners on a multiple of the cell size: 0.3 / 0.1 is not 3 in binary.
constexpr double kAlignmentTolerance = 1e-9;

int NumCells(double from, double to) {
  const double count = std::max(1.0, to - from);
  if (!(count < std::numeric_limits<int>::max())) {
    throw std::invalid_argument("terrain.grid: the box has more cells than can be counted");
  }
  return static_cast<int>(count);
}

}  // namespace

Eigen::Vector2d Grid::CellCenter(int row, int col) const {
  return north_west_in_world + Eigen::Vector2d(col + 0.5, -(row + 0.5)) * cell_size_m;
}

std::optional<cv::Point> Grid::CellAt(const Eigen::Vector2d& place_in_world) const {
  const double col = std::floor((place_in_world.x() - north_west_in_world.x()) / cell_size_m);
  const double row = std::floor((north_west_in_world.y() - place_in_world.y()) / cell_size_m);
  const bool is_inside = row >= 0.0 && col >= 0.0 && row < num_rows && col < num_cols;
  if (!is_inside) return std::nullopt;
  return cv::Point(static_cast<int>(col), static_cast<int>(row));
}

cv::Rect Grid::CellsAround(const Polygon& polygon, double reach) const {
  if (polygon.empty()) return {};
  Eigen::Vector2d low = polygon.front(), high = polygon.front();
  for (const Eigen::Vector2d& vertex : polygon) {
    low = low.cwiseMin(vertex);
    high = high.cwiseMax(vertex);
  }
  const auto clamp = [](double cells, int end) {
    return static_cast<int>(std::clamp(cells, 0.0, double(end)));
  };
  const double west = (low.x() - reach - north_west_in_world.x()) / cell_size_m;
  const double east = (high.x() + reach - north_west_in_world.x()) / cell_size_m;
  const double north = (north_west_in_world.y() - high.y() - reach) / cell_size_m;
  const double south = (north_west_in_world.y() - low.y() + reach) / cell_size_m;
  return {cv::Point(clamp(std::floor(west), num_cols), clamp(std::floor(north), num_rows)),
          cv::Point(clamp(std::ceil(east), num_cols), clamp(std::ceil(south), num_rows))};
}

std::vector<cv::Point> Grid::CellsIn(const Polygon& polygon) const {
  const cv::Rect around = CellsAround(polygon, 0.0);
  std::vector<cv::Point> cells;
  for (int row = around.y; row < around.y + around.height; ++row) {
    for (int col = around.x; col < around.x + around.width; ++col) {
      if (Contains(polygon, CellCenter(row, col))) cells.emplace_back(col, row);
    }
  }
  return cells;
}

Grid Grid::Part(const cv::Rect& cells) const {
  Grid part = *this;
  part.north_west_in_world += Eigen::Vector2d(cells.x, -cells.y) * cell_size_m;
  part.num_rows = cells.height;
  part.num_cols = cells.width;
  return part;
}

Grid GridAround(const Eigen::Vector2d& min_in_world,
                const Eigen::Vector2d& max_in_world,
                double cell_size_m) {
  if (!(std::isfinite(cell_size_m) && cell_size_m > 0.0)) {
    throw std::invalid_argument("terrain.cell_size_m = " + std::to_string(cell_size_m) +
                                ": must be positive");
  }
  if (!min_in_world.allFinite() || !max_in_world.allFinite() ||
      (min_in_world.array() > max_in_world.array()).any()) {
    throw std::invalid_argument("terrain.grid: the box is empty or not finite");
  }
  const Eigen::Vector2d first = (min_in_world / cell_size_m).array() + kAlignmentTolerance;
  const Eigen::Vector2d last = (max_in_world / cell_size_m).array() - kAlignmentTolerance;
  const double west = std::floor(first.x()), north = std::ceil(last.y());
  Grid grid;
  grid.north_west_in_world = Eigen::Vector2d(west, north) * cell_size_m;
  grid.cell_size_m = cell_size_m;
  grid.num_rows = NumCells(std::floor(first.y()), north);
  grid.num_cols = NumCells(west, std::ceil(last.x()));
  return grid;
}

}  // namespace freelsd
