// Private to poses/. YAML of calibration files, by yaml-cpp.
#pragma once

#include <string_view>

#include <nlohmann/json.hpp>

namespace freelsd {

// Reads the first document: maps, lists, text, numbers, null. Throws std::invalid_argument with the
// line, also for anchors, aliases, duplicate keys and text beyond the limits of size and depth.
nlohmann::json ParseYaml(std::string_view text);

}  // namespace freelsd
