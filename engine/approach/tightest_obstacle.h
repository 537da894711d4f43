// Private to approach/: the obstacle that a path passes most closely.
#pragma once

#include <optional>

#include "engine/approach/path_check.h"

namespace freelsd {

// Both as PathObstacle defines it; nothing where there is no obstacle. `aircraft` with its margins.
std::optional<PathObstacle> TightestOnFinal(const Approach& approach,
                                            const ClearanceSurface& surface,
                                            const Aircraft& aircraft,
                                            const ApproachOptions& options);
std::optional<PathObstacle> TightestOnCircle(const Approach& approach,
                                             const ClearanceSurface& surface,
                                             const Aircraft& aircraft);

// The one with less spare clearance.
std::optional<PathObstacle> Tighter(const std::optional<PathObstacle>& a,
                                    const std::optional<PathObstacle>& b);

}  // namespace freelsd
