// Private to approach/: the climb that breaks an approach off, and the last place where it may
// begin.
#pragma once

#include <optional>
#include <vector>

#include "engine/approach/path_check.h"

namespace freelsd {

// As GoAround defines it. `scenarios`: the same approach in each wind that it must be safe in; the
// first is flown. They must not be empty. `surface` covers all ground of the map below final and
// climb (MakeClimbSurface); `aircraft` with its margins.
//
// The climb needs the whole safety margin everywhere. The lesser clearance of the final's end is
// for ground on which the aircraft lands.
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
