// Coordinate systems of tables of poses. Private to poses/.
#pragma once

#include <memory>
#include <string>

#include "engine/geometry/geometry.h"

struct pj_ctx;
struct PJconsts;

namespace freelsd {

// Not thread-safe.
class CoordinateSystem {
 public:
  // "epsg:32632", "wgs84 utm 32n", "+proj=utm +zone=32 +datum=wgs84", "+proj=longlat +ellps=wgs84",
  // in lower case. Throws std::invalid_argument for any other, and for what is no projection of
  // degrees or lengths.
  explicit CoordinateSystem(const std::string& name);
  ~CoordinateSystem();
  CoordinateSystem(const CoordinateSystem&) = delete;
  CoordinateSystem& operator=(const CoordinateSystem&) = delete;

  // x: longitude or easting, y: latitude or northing. Altitude 0. Throws std::invalid_argument if
  // the place is not on the earth or not in the system's area.
  GeoPoint PlaceOf(double x, double y) const;
  // True if heights are above the ellipsoid. Otherwise their datum is unknown.
  bool IsEllipsoidal() const { return code_ == "4979"; }

 private:
  // False if the name is of no projection of degrees or lengths.
  bool SetArea(const std::string& name);

  std::string code_;
  // Where it may be used.
  double west_deg_ = -180.0, south_deg_ = -90.0, east_deg_ = 180.0, north_deg_ = 90.0;
  pj_ctx* context_ = nullptr;
  // Nothing for longitude and latitude of WGS84.
  PJconsts* wgs84_from_system_ = nullptr;
};

}  // namespace freelsd
