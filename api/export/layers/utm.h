// Position of a site's grid in UTM (UPS near the poles).
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
// Easting and northing (rows of the matrix) from (column, row, 1) of pixel corners; a least-squares
// fit at the grid's four corners. Six numbers: UTM is rotated and scaled against east-north.
Eigen::Matrix<double, 2, 3> UtmFromPixel(const Grid& grid, const Utm& utm, const LocalFrame& frame);

}  // namespace freelsd
