// Private to approach/: the obstacle that a path passes most closely.
#pragma once

#include <optional>

#include "engine/approach/path_check.h"

namespace freelsd {

// The obstacle that PathObstacle defines, on the final or on the circle. Nothing if there is no
// obstacle. `aircraft` must include its margins (WithPositionMargin).
std::optional<PathObstacle> TightestOnFinal(const Approach& approach,
                                            const ClearanceSurface& surface,
                                            const Aircraft& aircraft,
                                            const ApproachOptions& options);
std::optional<PathObstacle> TightestOnCircle(const Approach& approach,
                                             const ClearanceSurface& surface,
                                             const Aircraft& aircraft);

// The obstacle with less spare clearance; the other one if one of them is empty.
std::optional<PathObstacle> Tighter(const std::optional<PathObstacle>& a,
                                    const std::optional<PathObstacle>& b);

}  // namespace freelsd
