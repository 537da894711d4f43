// Bounding boxes at the antimeridian.
#pragma once

#include <array>
#include <vector>

#include "storage/site_store.h"

namespace freelsd {

// One or two boxes within [-180, 180] degrees that do not cross the antimeridian. Longitudes of
// `box` may leave this range.
std::vector<BoundingBox> PlainBoxes(const BoundingBox& box);

// True if the boxes overlap. `a` may cross the antimeridian, `plain` must not.
bool Meets(const BoundingBox& a, const BoundingBox& plain);

// The parts of `box` as PlainBoxes gives them, and the antimeridian's other side where they touch
// it.
std::vector<BoundingBox> TouchingBoxes(const BoundingBox& box);

// An R*Tree needs west <= east. If the box crosses the antimeridian, its east exceeds 180 degrees.
BoundingBox Unrolled(const BoundingBox& box);
BoundingBox Rolled(const BoundingBox& unrolled);

// Unrolled boxes with west_above_deg < west <= west_up_to_deg and east >= east_from_deg.
struct LongitudeSearch {
  double west_above_deg, west_up_to_deg, east_from_deg;
};
// A box that overlaps `box` along the parallel is found by exactly one search, another box by none.
std::array<LongitudeSearch, 2> SearchesFor(const BoundingBox& box);

}  // namespace freelsd
