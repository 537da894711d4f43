// Private to export/. Places in UTM (UPS near the poles).
#pragma once

#include <Eigen/Core>

#include "engine/geometry/geometry.h"
#include "engine/terrain/terrain.h"

namespace freelsd {

struct Utm {
  int zone = 0;  // 0: polar (UPS)
  bool is_north = true;

  int Epsg() const;
};

Utm ZoneOf(const GeoPoint& origin);
// (easting, northing) in the given zone and hemisphere, also for places beyond their borders.
Eigen::Vector2d UtmFromGeo(const Utm& utm, const GeoPoint& place);
// The altitude of the result is 0.
GeoPoint GeoFromUtm(const Utm& utm, const Eigen::Vector2d& place_in_utm);
// Affine transform from (column, row, 1) of a pixel corner to (easting, northing), fitted by least
// squares to the grid's four corners. It contains rotation and scale, because UTM axes differ from
// local east and north.
Eigen::Matrix<double, 2, 3> UtmFromPixel(const Grid& grid, const Utm& utm, const LocalFrame& frame);

}  // namespace freelsd
