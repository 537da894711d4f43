// Private to import/. As much of YAML as calibration files use: maps by indentation, lists of
// numbers in brackets or with dashes, plain and quoted text.
#pragma once

#include <string_view>

#include <nlohmann/json.hpp>

namespace freelsd {

// Throws std::invalid_argument with the line, also for more than 64 KiB or a depth of more than 16.
nlohmann::json ParseYaml(std::string_view text);

}  // namespace freelsd
