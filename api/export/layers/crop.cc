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
  return WindowOf(map, layers, box);
}

}  // namespace freelsd
