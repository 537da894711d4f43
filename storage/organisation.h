// Names of organisations, which share a database and see nothing of each other.
#pragma once

#include <string_view>

namespace freelsd {

// Of whoever names none.
inline constexpr char kDefaultOrganisation[] = "default";
// Lower-case letters, digits and hyphens, 1 to 64: it is also a folder's name.
bool IsOrganisationName(std::string_view name);

}  // namespace freelsd
