// Which images are removed to make room. Never sites.
#pragma once

#include <string>
#include <vector>

#include "server/service.h"

namespace freelsd {

// Idle flights, oldest first, whose images are too old or too many by the settings.
std::vector<std::string> FlightsToRetire(const Service& service);

}  // namespace freelsd
