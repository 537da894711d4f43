#include "engine/geometry/polygon.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace freelsd {
namespace {

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Rectangle around the points with one side along `side` (unit vector).
Polygon RectangleAlong(const Polygon& points, const Eigen::Vector2d& side) {
  const Eigen::Vector2d normal(-side.y(), side.x());
  double u_min = std::numeric_limits<double>::infinity(), u_max = -u_min;
  double v_min = u_min, v_max = -u_min;
  for (const Eigen::Vector2d& point : points) {
    u_min = std::min(u_min, side.dot(point));
    u_max = std::max(u_max, side.dot(point));
    v_min = std::min(v_min, normal.dot(point));
    v_max = std::max(v_max, normal.dot(point));
  }
  return {side * u_min + normal * v_min,
          side * u_max + normal * v_min,
          side * u_max + normal * v_max,
          side * u_min + normal * v_max};
}

}  // namespace

double SignedArea(const Polygon& polygon) {
  double doubled = 0.0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    // Relative to the first vertex, because large coordinates would cancel.
    const Eigen::Vector2d& next = polygon[(i + 1) % polygon.size()];
    doubled += Cross(polygon[i] - polygon.front(), next - polygon.front());
  }
  return 0.5 * doubled;
}

double Area(const Polygon& polygon) { return std::abs(SignedArea(polygon)); }

Eigen::Vector2d Centroid(const Polygon& polygon) {
  Eigen::Vector2d weighted = Eigen::Vector2d::Zero();
  double doubled_area = 0.0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d a = polygon[i] - polygon.front();
    const Eigen::Vector2d b = polygon[(i + 1) % polygon.size()] - polygon.front();
    weighted += Cross(a, b) * (a + b);
    doubled_area += Cross(a, b);
  }
  if (std::abs(doubled_area) > 1e-12) return polygon.front() + weighted / (3.0 * doubled_area);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& vertex : polygon) sum += vertex;
  return polygon.empty() ? sum : Eigen::Vector2d(sum / static_cast<double>(polygon.size()));
}

int WindingNumber(const Polygon& polygon, const Eigen::Vector2d& point) {
  int winding = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon[(i + 1) % polygon.size()];
    const double side = Cross(b - a, point - a);
    if (a.y() <= point.y() && b.y() > point.y() && side > 0.0) ++winding;
    if (a.y() > point.y() && b.y() <= point.y() && side < 0.0) --winding;
  }
  return winding;
}

bool Contains(const Polygon& polygon, const Eigen::Vector2d& point) {
  return WindingNumber(polygon, point) != 0;
}

Polygon ConvexHull(Polygon points) {
  std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  Polygon hull;
  const auto extend = [&hull](const Eigen::Vector2d& point, size_t floor) {
    while (hull.size() >= floor + 2 &&
           Cross(hull.back() - hull[hull.size() - 2], point - hull.back()) <= 0.0) {
      hull.pop_back();
    }
    hull.push_back(point);
  };
  for (const Eigen::Vector2d& point : points) extend(point, 0);
  const size_t lower = hull.size() - 1;
  for (size_t i = points.size() - 1; i-- > 0;) extend(points[i], lower);
  hull.pop_back();
  return hull;
}

Polygon MinAreaRectangle(const Polygon& points) {
  const Polygon hull = ConvexHull(points);
  if (hull.empty()) return {};
  Polygon best = RectangleAlong(hull, Eigen::Vector2d::UnitX());
  if (hull.size() < 2) return best;
  double best_area = std::numeric_limits<double>::infinity();
  // One side of the smallest rectangle lies along an edge of the hull (Toussaint 1983).
  for (size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d edge = hull[(i + 1) % hull.size()] - hull[i];
    if (edge.norm() == 0.0) continue;
    const Polygon rectangle = RectangleAlong(hull, edge.normalized());
    const double area = Area(rectangle);
    if (area < best_area) {
      best_area = area;
      best = rectangle;
    }
  }
  return best;
}

Polygon ConvexIntersection(const Polygon& a, const Polygon& b) {
  Polygon inside = a;
  for (size_t i = 0; i < b.size() && !inside.empty(); ++i) {
    const Eigen::Vector2d& from = b[i];
    const Eigen::Vector2d edge = b[(i + 1) % b.size()] - from;
    Polygon clipped;
    for (size_t j = 0; j < inside.size(); ++j) {
      const Eigen::Vector2d& p = inside[j];
      const Eigen::Vector2d& q = inside[(j + 1) % inside.size()];
      const double side_p = Cross(edge, p - from), side_q = Cross(edge, q - from);
      if (side_p >= 0.0) clipped.push_back(p);
      if ((side_p < 0.0) != (side_q < 0.0)) {
        clipped.push_back(p + (q - p) * (side_p / (side_p - side_q)));
      }
    }
    inside = std::move(clipped);
  }
  return inside.size() < 3 ? Polygon{} : inside;
}

double OverlapRatio(const Polygon& a, const Polygon& b) {
  const Polygon common = ConvexIntersection(a, b);
  if (common.empty()) return 0.0;
  const double area = Area(common);
  return area / (Area(a) + Area(b) - area);
}

}  // namespace freelsd
