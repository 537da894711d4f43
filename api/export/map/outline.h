// Private to map/. Outline of a box in world, and the boxes around it in other coordinates.
#pragma once

#include <vector>

#include "api/export/map/map.h"

namespace freelsd {

// Throws std::invalid_argument unless the box is finite and not empty.
void CheckExtent(const WorldBox& extent);
// Places on the edges of the box. Longitudes go on beyond 180 degrees, so that they are near the
// origin's.
std::vector<GeoPoint> OutlineOf(const WorldBox& extent, const LocalFrame& local_frame);
// Box around the outline. A box across the antimeridian goes around the earth, because a TileJSON's
// bounds must not cross it.
GeoBounds BoundsOf(const WorldBox& extent, const LocalFrame& local_frame);
GeoPoint CenterOf(const WorldBox& extent, const LocalFrame& local_frame);

}  // namespace freelsd
