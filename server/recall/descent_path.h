// The path of a descent as an answer gives it, and as its terrain is checked. Private to recall.
#pragma once

#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/geometry/geometry.h"
#include "engine/glide/glide.h"

namespace freelsd {

// Adds `path` (a LineString with altitudes), `times_s` (one for each vertex), and a warning if
// surplus height is left at the start of the final. `local_frame` is the approach's.
void AddDescent(const Descent& descent, const LocalFrame& local_frame, nlohmann::json& answer);

// The part of the path that the planner has not checked: to the start of the final. It is lowered
// in proportion to time, so that it arrives at the height of the worst case.
std::vector<GeoPoint> UncheckedPath(const Descent& descent,
                                    const Glide& worst,
                                    const LocalFrame& local_frame);

}  // namespace freelsd
