// Position of a site's grid in UTM (UPS near the poles).
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
// Affine transform from (column, row, 1) of a pixel corner to (easting, northing), fitted by least
// squares to the grid's four corners. It contains rotation and scale, because UTM axes differ from
// local east and north.
Eigen::Matrix<double, 2, 3> UtmFromPixel(const Grid& grid, const Utm& utm, const LocalFrame& frame);

}  // namespace freelsd
