// Private to approach/: why a region is refused before any path is tried.
#pragma once

#include <optional>
#include <string>

#include "engine/approach/approach_geometry.h"
#include "engine/approach/touchdown.h"

namespace freelsd {

struct Refusal {
  RejectReason reason = RejectReason::kNoTerrain;
  std::string detail;
};

// What speaks against the region itself or against every place in it, in the order of the paper's
// stages. `required_distance` to hazard.
std::optional<Refusal> RefuseGround(const PlanRequest& request,
                                    const FootprintContent& content,
                                    double required_distance,
                                    const Aircraft& aircraft);
std::optional<Refusal> RefuseWind(const WindCase& wind);

}  // namespace freelsd
