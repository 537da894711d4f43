// Shapes that nobody can mean. Private to obstacles/.
#pragma once

#include <vector>

#include "engine/geometry/geometry.h"

namespace freelsd {

// True if all points are at one place. Altitudes do not count.
bool IsOnePlace(const std::vector<GeoPoint>& points);
// True if fewer than three points of the ring differ, or if all are on one line.
bool IsFlat(const std::vector<GeoPoint>& ring);
// True if two sides of the ring cross. Sides that only touch do not cross.
bool CrossesItself(const std::vector<GeoPoint>& ring);

// The ring, or its two parts if it crosses the antimeridian. Each part is closed by neighbours.
std::vector<std::vector<GeoPoint>> CutAtAntimeridian(const std::vector<GeoPoint>& ring);

}  // namespace freelsd
