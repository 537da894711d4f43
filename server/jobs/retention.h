// Selects flights whose images will be removed to free disk space. Sites are never removed.
#pragma once

#include <string>
#include <vector>

#include "server/jobs/service.h"

namespace freelsd {

// Ids of idle flights, oldest first: all that exceed the configured age. If the images exceed the
// configured size, the oldest idle flight is always included.
std::vector<std::string> FlightsToRetire(const Service& service);

// Flights whose picture of the ground is to be removed, under the same limits. For size, a picture
// goes only when no photographs are left to remove. The map stays.
std::vector<std::string> FlightsToRetirePicturesOf(const Service& service);

}  // namespace freelsd
