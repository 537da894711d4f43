// A flight's warnings as stored: sentences by where they come from, so that each source can replace
// its own.
#pragma once

#include <string>
#include <vector>

namespace freelsd {

// All take and give FlightRow::warnings_json.
std::string ReplaceWarnings(const std::string& warnings_json,
                            const std::string& source,
                            const std::vector<std::string>& sentences);
// Each sentence once.
std::string AddWarnings(const std::string& warnings_json,
                        const std::string& source,
                        const std::vector<std::string>& sentences);
std::vector<std::string> AllWarnings(const std::string& warnings_json);

}  // namespace freelsd
