#include "api/import/obstacles/shape.h"

#include <algorithm>
#include <cmath>

namespace freelsd {
namespace {

// About 1 cm, and the last digit that files commonly have. A side that reaches over another by less
// only touches it.
constexpr double kTouchDeg = 1e-7;

// Plane of longitude and latitude in degrees, because sides are straight there.
Polygon InDegrees(const std::vector<GeoPoint>& points) {
  Polygon polygon;
  for (const GeoPoint& point : points) {
    polygon.emplace_back(point.longitude_deg, point.latitude_deg);
  }
  return polygon;
}

struct Side {
  Eigen::Vector2d begin;
  Eigen::Vector2d end;
  // Unit vector; zero if both ends are one place.
  Eigen::Vector2d along;
};

// 1 or -1 for the two sides of the line, 0 on it.
int SignBeside(const Side& line, const Eigen::Vector2d& point) {
  const Eigen::Vector2d to_point = point - line.begin;
  const double distance_deg = line.along.x() * to_point.y() - line.along.y() * to_point.x();
  if (std::abs(distance_deg) <= kTouchDeg) return 0;
  return distance_deg > 0.0 ? 1 : -1;
}

bool IsCutBy(const Side& side, const Side& line) {
  return SignBeside(line, side.begin) * SignBeside(line, side.end) < 0;
}

bool Overlap(double a, double b, double c, double d) {
  return std::max(a, b) >= std::min(c, d) && std::max(c, d) >= std::min(a, b);
}

// Most pairs of sides are far apart.
bool AreNear(const Side& a, const Side& b) {
  return Overlap(a.begin.x(), a.end.x(), b.begin.x(), b.end.x()) &&
         Overlap(a.begin.y(), a.end.y(), b.begin.y(), b.end.y());
}

// The part of the ring on one side of the meridian; `sign` 1 is the west (Sutherland, Hodgman
// 1974).
std::vector<GeoPoint> PartBeside(const std::vector<GeoPoint>& ring,
                                 double meridian_deg,
                                 double sign) {
  std::vector<GeoPoint> part;
  for (size_t i = 0; i < ring.size(); ++i) {
    const GeoPoint& a = ring[i];
    const GeoPoint& b = ring[(i + 1) % ring.size()];
    const double a_deg = sign * (meridian_deg - a.longitude_deg);
    const double b_deg = sign * (meridian_deg - b.longitude_deg);
    if (a_deg >= 0.0) part.push_back(a);
    if (a_deg * b_deg >= 0.0) continue;
    const double ratio = a_deg / (a_deg - b_deg);
    part.push_back(
        {a.latitude_deg + ratio * (b.latitude_deg - a.latitude_deg), meridian_deg, a.altitude_m});
  }
  return part;
}

}  // namespace

std::vector<std::vector<GeoPoint>> CutAtAntimeridian(const std::vector<GeoPoint>& ring) {
  std::vector<GeoPoint> unwrapped = ring;
  double west_deg = 180.0, east_deg = -180.0;
  for (size_t i = 0; i < ring.size(); ++i) {
    const double before_deg = unwrapped[i > 0 ? i - 1 : 0].longitude_deg;
    double& longitude_deg = unwrapped[i].longitude_deg;
    longitude_deg = before_deg + std::remainder(longitude_deg - before_deg, 360.0);
    west_deg = std::min(west_deg, longitude_deg);
    east_deg = std::max(east_deg, longitude_deg);
  }
  if (west_deg >= -180.0 && east_deg <= 180.0) return {unwrapped};
  const double meridian_deg = east_deg > 180.0 ? 180.0 : -180.0;
  std::vector<std::vector<GeoPoint>> parts;
  for (const double sign : {1.0, -1.0}) {
    std::vector<GeoPoint> part = PartBeside(unwrapped, meridian_deg, sign);
    // The half that left the range comes back from the other side.
    const double turn_deg =
        meridian_deg > 0.0 ? (sign < 0.0 ? -360.0 : 0.0) : (sign > 0.0 ? 360.0 : 0.0);
    for (GeoPoint& point : part) point.longitude_deg += turn_deg;
    if (!IsFlat(part)) parts.push_back(std::move(part));
  }
  return parts;
}

bool IsOnePlace(const std::vector<GeoPoint>& points) {
  return std::all_of(points.begin(), points.end(), [&points](const GeoPoint& point) {
    return point.latitude_deg == points.front().latitude_deg &&
           point.longitude_deg == points.front().longitude_deg;
  });
}

bool IsFlat(const std::vector<GeoPoint>& ring) { return ConvexHull(InDegrees(ring)).size() < 3; }

bool CrossesItself(const std::vector<GeoPoint>& ring) {
  const Polygon corners = InDegrees(ring);
  std::vector<Side> sides;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d& next = corners[(i + 1) % corners.size()];
    sides.push_back({corners[i], next, (next - corners[i]).normalized()});
  }
  for (size_t i = 0; i < sides.size(); ++i) {
    for (size_t j = i + 1; j < sides.size(); ++j) {
      if (!AreNear(sides[i], sides[j])) continue;
      if (IsCutBy(sides[i], sides[j]) && IsCutBy(sides[j], sides[i])) return true;
    }
  }
  return false;
}

}  // namespace freelsd
