#include <algorithm>
#include <cmath>
#include <limits>

#include "api/export/layers/layers.h"

namespace freelsd {
namespace {

double DistanceToEdge(const Eigen::Vector2d& a,
                      const Eigen::Vector2d& b,
                      const Eigen::Vector2d& p) {
  const double squared_length = (b - a).squaredNorm();
  const double along = squared_length > 0.0 ? (p - a).dot(b - a) / squared_length : 0.0;
  return (p - a - std::clamp(along, 0.0, 1.0) * (b - a)).norm();
}

// Distance from the polygon, 0 inside.
double DistanceTo(const Polygon& polygon, const Eigen::Vector2d& place) {
  if (Contains(polygon, place)) return 0.0;
  double distance = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& next = polygon[(i + 1) % polygon.size()];
    distance = std::min(distance, DistanceToEdge(polygon[i], next, place));
  }
  return distance;
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
  const cv::Rect outer = map.grid.CellsAround(footprint, margin_m);
  cv::Rect box = map.grid.CellsAround(footprint, 0.0);
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
           .hazard = layers.hazard(box).clone(),
           .distance = layers.distance(box).clone(),
           .min_clear_class_posterior = layers.min_clear_class_posterior,
           .min_grass_posterior = layers.min_grass_posterior}};
}

}  // namespace freelsd
