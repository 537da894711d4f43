// The ground that an evaluation looks at, for a map.
#pragma once

#include <string>

#include "api/api.h"

namespace freelsd {

// The box as a GeoJSON Polygon. Empty if the box is empty.
std::string AreaJson(const Box& area, const LocalFrame& local_frame);

}  // namespace freelsd
