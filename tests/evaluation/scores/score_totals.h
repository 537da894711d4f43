// Input: the records of worlds. Output: totals of flown sites, of found fields, of things on the
// ground and of heights without tilt. Records of older programs, without these scores, are left
// out.
#pragma once

#include <nlohmann/json.hpp>

namespace freelsd {

// How often landings at accepted sites fail. The interval is a bootstrap over the worlds, because
// the sites of a world share its errors.
nlohmann::json FlownTotals(const nlohmann::json& records);

// Fields as shares of what the planner accepts on maps without error, and what the others lack.
nlohmann::json FoundTotals(const nlohmann::json& records);

// By kind, width and height: how many are found, unknown, hazard, missed.
nlohmann::json ThingTotals(const nlohmann::json& records);

// For the totals of the maps.
nlohmann::json DetiltedTotals(const nlohmann::json& records);

}  // namespace freelsd
