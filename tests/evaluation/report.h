// Input: the records of worlds. Output: the totals, as JSON and as a table; what got better or
// worse against an older report.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace freelsd {

// {safety, flown, found, things, maps, frontend, poses, cost, settings, worlds}; `worlds` are the
// records themselves, by seed, so that a report can be continued.
nlohmann::json MakeReport(const nlohmann::json& settings, const nlohmann::json& records);

std::string TableOf(const nlohmann::json& report);
// One line for each number of the totals that differs, with the direction that is better.
std::string Comparison(const nlohmann::json& older, const nlohmann::json& newer);

}  // namespace freelsd
