// Edits a flight's stored warnings: sentences by source, so that a source can replace its own ones.
#pragma once

#include <string>
#include <vector>

namespace freelsd {

// These functions take FlightRow::warnings_json; the first two return its new value.
std::string ReplaceWarnings(const std::string& warnings_json,
                            const std::string& source,
                            const std::vector<std::string>& sentences);
// Adds sentences that the source does not have yet.
std::string AddWarnings(const std::string& warnings_json,
                        const std::string& source,
                        const std::vector<std::string>& sentences);
std::vector<std::string> AllWarnings(const std::string& warnings_json);

}  // namespace freelsd
