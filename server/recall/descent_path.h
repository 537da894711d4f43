// Writes the path of a descent into an answer, and selects the part whose terrain is checked.
// Private to recall.
#pragma once

#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/geometry/geometry.h"
#include "engine/glide/glide.h"

namespace freelsd {

// Adds three members to `answer`: `path` (a LineString with altitudes), `times_s` (one for each
// vertex), and a warning if surplus height is left at the start of the final. `local_frame` is the
// frame of the approach.
void AddDescent(const Descent& descent, const LocalFrame& local_frame, nlohmann::json& answer);

// The part of the path to the start of the final. The planner has not checked this part. The
// returned path is lowered in proportion to time, so that it ends at the arrival height of `worst`.
std::vector<GeoPoint> UncheckedPath(const Descent& descent,
                                    const Glide& worst,
                                    const LocalFrame& local_frame);

}  // namespace freelsd
