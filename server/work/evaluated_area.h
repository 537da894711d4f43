// The ground that an evaluation looks at, for a map.
#pragma once

#include <string>
#include <vector>

#include "api/api.h"

namespace freelsd {

// The smallest box, parallel to the axes of the world frame, around the regions: a GeoJSON Polygon.
// Empty if there are no regions.
std::string AreaJson(const std::vector<Candidate>& regions, const LocalFrame& local_frame);

}  // namespace freelsd
