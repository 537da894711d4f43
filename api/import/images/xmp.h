// The properties of an XMP packet. Private to images/.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace freelsd {

struct XmpProperties {
  // By lower-case "prefix.name". Of a property that comes twice, the first value.
  std::map<std::string, std::string> values;
  // What could not be read.
  std::vector<std::string> warnings;
};
// Reads also packets that are not well-formed, property by property. Several threads may call this
// function at once.
XmpProperties ReadXmp(std::string_view packet);

}  // namespace freelsd
