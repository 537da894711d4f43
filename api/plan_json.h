// Pieces of a plan's JSON that sites and approaches share.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "api/api.h"

namespace freelsd {

// As in the contract: "landable", "approach_blocked".
std::string NameOf(Verdict verdict);
std::string NameOf(RejectReason reason);
// "left" or "right".
std::string DirectionName(LoiterDirection direction);
// heading, distance, height, loiter radius and direction, least clearance. The heading is from true
// north at the touchdown; the world's, of the origin, is 0.05 degrees off a kilometre east at 80 N.
nlohmann::json ApproachProperties(const Approach& approach, const LocalFrame& local_frame);

}  // namespace freelsd
