// Selects flights whose images are removed to free disk space. Sites are never removed.
#pragma once

#include <string>
#include <vector>

#include "server/work/service.h"

namespace freelsd {

// Ids of idle flights, oldest first, whose images exceed the configured age or size.
std::vector<std::string> FlightsToRetire(const Service& service);

}  // namespace freelsd
