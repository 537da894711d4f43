// Polygons in the horizontal plane of the world frame (or in the image).
#pragma once

#include <vector>

#include <Eigen/Core>

namespace freelsd {

// Open ring: the last vertex is not the first one again. Counter-clockwise has positive area.
using Polygon = std::vector<Eigen::Vector2d>;

double SignedArea(const Polygon& polygon);
double Area(const Polygon& polygon);
Eigen::Vector2d Centroid(const Polygon& polygon);
// How often the polygon winds around the point (Weiler 1994); 0 is outside. Points on the boundary
// count as inside on lower and left edges only.
int WindingNumber(const Polygon& polygon, const Eigen::Vector2d& point);
bool Contains(const Polygon& polygon, const Eigen::Vector2d& point);
// Convex hull (Andrew's monotone chain), counter-clockwise.
Polygon ConvexHull(Polygon points);
// Rectangle of least area around the points (rotating calipers), counter-clockwise, four corners.
Polygon MinAreaRectangle(const Polygon& points);

// Common part of two convex polygons, both counter-clockwise (Sutherland-Hodgman); empty if none.
Polygon ConvexIntersection(const Polygon& a, const Polygon& b);
// Area of the common part over area of the union, 0..1.
double OverlapRatio(const Polygon& a, const Polygon& b);

}  // namespace freelsd
