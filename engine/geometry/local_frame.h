// The world frame: local east-north-up, metres, tangent to WGS84 at an origin.
#pragma once

#include <Eigen/Core>
#include <GeographicLib/LocalCartesian.hpp>

namespace freelsd {

// WGS84. The altitude uses the flight's datum; only altitude differences matter.
struct GeoPoint {
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  double altitude_m = 0.0;
};

class LocalFrame {
 public:
  explicit LocalFrame(const GeoPoint& origin);
  const GeoPoint& origin() const { return origin_; }
  Eigen::Vector3d WorldFromGeo(const GeoPoint& point) const;
  GeoPoint GeoFromWorld(const Eigen::Vector3d& point_in_world) const;

 private:
  GeoPoint origin_;
  GeographicLib::LocalCartesian cartesian_;
};

}  // namespace freelsd
