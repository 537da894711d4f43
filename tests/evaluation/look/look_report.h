// Input: records of RunLook. Output: how much more the suggested legs gained than random ones.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace freelsd {

// Of one world: gains of landing value of the suggested legs, the mean of the random pairs and
// their 75th percentile; and the share of random pairs that gained less than the suggested legs,
// ties counting half.
nlohmann::json LookGains(const nlohmann::json& record);

// {settings, totals, worlds}: means over worlds with 95 % intervals (bootstrap over worlds).
nlohmann::json LookReport(const nlohmann::json& settings, const nlohmann::json& records);

// As Markdown.
std::string LookTable(const nlohmann::json& report);

}  // namespace freelsd
