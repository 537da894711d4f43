#include <algorithm>
#include <cmath>
#include <limits>

#include "api/export/export.h"

namespace freelsd {
namespace {

double DistanceToEdge(const Eigen::Vector2d& a,
                      const Eigen::Vector2d& b,
                      const Eigen::Vector2d& p) {
  const double squared_length = (b - a).squaredNorm();
  const double along = squared_length > 0.0 ? (p - a).dot(b - a) / squared_length : 0.0;
  return (p - a - std::clamp(along, 0.0, 1.0) * (b - a)).norm();
}

// 0 inside.
double DistanceTo(const Polygon& polygon, const Eigen::Vector2d& place) {
  if (Contains(polygon, place)) return 0.0;
  double distance = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& next = polygon[(i + 1) % polygon.size()];
    distance = std::min(distance, DistanceToEdge(polygon[i], next, place));
  }
  return distance;
}

// Cells of the grid that the polygon's bounding box, widened by the margin, touches.
cv::Rect CellsAround(const Grid& grid, const Polygon& polygon, double margin_m) {
  Eigen::Vector2d low = polygon.front(), high = polygon.front();
  for (const Eigen::Vector2d& vertex : polygon) {
    low = low.cwiseMin(vertex);
    high = high.cwiseMax(vertex);
  }
  const auto in_cells = [&grid](double distance_m, int num_cells) {
    return std::clamp(distance_m / grid.cell_size_m, -1.0, num_cells + 1.0);
  };
  const Eigen::Vector2d& corner = grid.north_west_in_world;
  const double west = in_cells(low.x() - margin_m - corner.x(), grid.num_cols);
  const double east = in_cells(high.x() + margin_m - corner.x(), grid.num_cols);
  const double north = in_cells(corner.y() - high.y() - margin_m, grid.num_rows);
  const double south = in_cells(corner.y() - low.y() + margin_m, grid.num_rows);
  const cv::Point first(cvFloor(west), cvFloor(north)), end(cvCeil(east), cvCeil(south));
  return cv::Rect(first, end) & cv::Rect(0, 0, grid.num_cols, grid.num_rows);
}

Grid CropGrid(const Grid& grid, const cv::Rect& box) {
  Grid cropped = grid;
  cropped.north_west_in_world += Eigen::Vector2d(box.x, -box.y) * grid.cell_size_m;
  cropped.num_rows = box.height;
  cropped.num_cols = box.width;
  return cropped;
}

}  // namespace

SiteMap CropAround(const ElevationMap& map,
                   const HazardLayers& layers,
                   const Polygon& footprint,
                   double margin_m) {
  if (footprint.empty() || map.elevation.empty()) return {};
  const cv::Rect outer = CellsAround(map.grid, footprint, margin_m);
  cv::Rect box = CellsAround(map.grid, footprint, 0.0);
  for (int row = outer.y; row < outer.y + outer.height; ++row) {
    for (int col = outer.x; col < outer.x + outer.width; ++col) {
      const cv::Rect cell(col, row, 1, 1);
      if (!map.IsSeen(row, col) || (box & cell).area() > 0) continue;
      if (DistanceTo(footprint, map.grid.CellCenter(row, col)) <= margin_m) box |= cell;
    }
  }
  if (box.empty()) return {};
  const Grid grid = CropGrid(map.grid, box);
  return {{grid,
           map.elevation(box).clone(),
           map.upper(box).clone(),
           map.standard_deviation(box).clone(),
           map.num_points(box).clone(),
           map.position_sd_m,
           map.tilt_sd_deg,
           map.is_compared},
          {.grid = grid,
           .slope = layers.slope(box).clone(),
           .roughness = layers.roughness(box).clone(),
           .grass = layers.grass(box).clone(),
           .meadow = {},
           .objects = {},
           .hazard = layers.hazard(box).clone(),
           .distance = layers.distance(box).clone()}};
}

}  // namespace freelsd
