// Pieces of a plan's JSON that sites and approaches share.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "api/api.h"

namespace freelsd {

// "left" or "right".
std::string DirectionName(LoiterDirection direction);
// heading, distance, height, loiter radius and direction, least clearance.
nlohmann::json ApproachProperties(const Approach& approach);

}  // namespace freelsd
