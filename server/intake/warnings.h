// Edits a flight's stored warnings. They are grouped by source, so that a source can replace its
// own.
#pragma once

#include <string>
#include <vector>

namespace freelsd {

// All functions take the text of FlightRow::warnings_json. The first two return its new value.
std::string ReplaceWarnings(const std::string& warnings_json,
                            const std::string& source,
                            const std::vector<std::string>& sentences);
// Adds those sentences that the source does not have yet.
std::string AddWarnings(const std::string& warnings_json,
                        const std::string& source,
                        const std::vector<std::string>& sentences);
std::vector<std::string> AllWarnings(const std::string& warnings_json);

}  // namespace freelsd
