// Polygons in the horizontal plane of the world frame (or in the image).
#pragma once

#include <vector>

#include <Eigen/Core>

namespace freelsd {

// Open ring: the first vertex is not repeated at the end. The area of a counter-clockwise ring is
// positive.
using Polygon = std::vector<Eigen::Vector2d>;

double SignedArea(const Polygon& polygon);
double Area(const Polygon& polygon);
Eigen::Vector2d Centroid(const Polygon& polygon);
// Number of times the polygon winds around the point (Weiler 1994); 0 if the point is outside.
// Points on the boundary are inside only on lower and left edges.
int WindingNumber(const Polygon& polygon, const Eigen::Vector2d& point);
bool Contains(const Polygon& polygon, const Eigen::Vector2d& point);
// Convex hull (Andrew's monotone chain), counter-clockwise.
Polygon ConvexHull(Polygon points);
// Rectangle of least area around the points (rotating calipers), counter-clockwise, four corners.
Polygon MinAreaRectangle(const Polygon& points);

// Intersection of two convex polygons, both counter-clockwise (Sutherland-Hodgman); empty if they
// do not overlap.
Polygon ConvexIntersection(const Polygon& a, const Polygon& b);
// Area of the intersection divided by the area of the union, 0..1. Both polygons are convex and
// counter-clockwise.
double OverlapRatio(const Polygon& a, const Polygon& b);

}  // namespace freelsd
