// Where a site's grid lies in UTM (UPS near the poles).
#pragma once

#include <Eigen/Core>

#include "engine/geometry/geometry.h"
#include "engine/terrain/terrain.h"

namespace freelsd {

struct Utm {
  int zone = 0;  // 0: polar
  bool is_north = true;

  int Epsg() const;
};

Utm ZoneOf(const GeoPoint& origin);
// Rows: easting and northing from (column, row, 1), pixel corners; least squares over the grid's
// four corners. Local east-north is turned and scaled against UTM, so six numbers are needed.
Eigen::Matrix<double, 2, 3> UtmFromPixel(const Grid& grid, const Utm& utm, const LocalFrame& frame);

}  // namespace freelsd
