// Private to map/. Positions in the Web Mercator pyramid.
#pragma once

#include "api/export/map/map.h"

namespace freelsd {

// Length of a side of the whole world in pixels.
double WorldSizePx(int zoom);
// Position of a place in pixels from the north-western corner of the world. Latitudes are clamped
// to those of the pyramid.
Eigen::Vector2d PixelFromGeo(const GeoPoint& place, int zoom);
GeoPoint GeoFromPixel(const Eigen::Vector2d& pixel, int zoom);
// Size of a pixel on the ground.
double PixelSizeM(int zoom, double latitude_deg);

}  // namespace freelsd
