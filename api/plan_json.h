// Parts of a plan's JSON that sites and approaches share.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "api/api.h"

namespace freelsd {

// "landable", "unverified" or "rejected".
std::string NameOf(Verdict verdict);
// "left" or "right".
std::string DirectionName(LoiterDirection direction);
// Heading, distance, height, loiter radius and direction, least clearance, point of no return. The
// heading is relative to true north at the touchdown. Trap: north in the local frame is true north
// at the origin. At 80 N, the two differ by 0.05 deg per kilometre to the east.
nlohmann::json ApproachProperties(const Approach& approach, const LocalFrame& local_frame);
RankKey RankKeyOf(const std::string& verdict, double score, const std::string& id);

}  // namespace freelsd
