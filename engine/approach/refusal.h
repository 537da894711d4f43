// Private to approach/: reasons to refuse a region before any path is tried.
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

// Reason against the region as a whole.
std::optional<Refusal> RefuseRegion(const PlanRequest& request,
                                    const FootprintContent& content,
                                    const Aircraft& aircraft);
// The first reason against the region or against every place in it. Reasons are checked in the
// order of the paper's stages.
// `required_distance`: least distance of a touchdown from hazard, metres.
std::optional<Refusal> RefuseGround(const PlanRequest& request,
                                    const FootprintContent& content,
                                    double required_distance,
                                    const Aircraft& aircraft);
// Refuses a wind that is too strong to land in.
std::optional<Refusal> RefuseWind(const WindCase& wind, const Aircraft& aircraft);

}  // namespace freelsd
