// Private to approach/: the climb that breaks an approach off, and the last place where it may
// begin.
#pragma once

#include <optional>
#include <vector>

#include "engine/approach/path_check.h"

namespace freelsd {

// Finds the go-around that GoAround describes; nothing if it is clear from no point of the final.
// `scenarios`: the same approach in each wind that it must be safe in; the first is flown. They
// must not be empty. `surface` must cover all ground of the map below final and climb, as that of
// MakeClimbSurface does. `aircraft` must include its margins (WithPositionMargin).
//
// The climb needs the whole safety margin everywhere. The end of a final may have less clearance,
// but only because the aircraft lands on the ground below it.
std::optional<GoAround> FindGoAround(const std::vector<Approach>& scenarios,
                                     const ClearanceSurface& surface,
                                     const Aircraft& aircraft,
                                     const ApproachOptions& options);

// Heights below the final and straight ahead, to the end of the map.
ClearanceSurface MakeClimbSurface(const Approach& approach,
                                  const ElevationMap& map,
                                  const HazardLayers& hazards,
                                  const Aircraft& aircraft,
                                  const ApproachOptions& options);

}  // namespace freelsd
