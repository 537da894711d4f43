// Private to classification/. Logarithms of grey levels.
#pragma once

#include <array>

namespace freelsd {

// Logarithm of each grey level plus a small offset, which prevents noise in shadows from counting
// as texture. All values lie between 1 and 8 and are multiples of 2^-23.
using LogLevels = std::array<float, 256>;
const LogLevels& LogOfLevel();

}  // namespace freelsd
