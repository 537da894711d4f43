// Input: the records of worlds. Output: the totals, as JSON and as a table.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace freelsd {

// {safety, flown, found, things, maps, heights, frontend, poses, settings, worlds}; `worlds` are
// the records themselves, by seed, so that a report can be continued. Of runs that end with their
// map {maps, heights, poses, settings, worlds} alone.
nlohmann::json MakeReport(const nlohmann::json& settings, const nlohmann::json& records);

std::string TableOf(const nlohmann::json& report);

}  // namespace freelsd
