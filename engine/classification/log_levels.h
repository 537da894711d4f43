// Private to classification/. Logarithms of grey levels.
#pragma once

#include <array>

namespace freelsd {

// By grey level. Levels are raised a little first, so that noise in shadows does not count as
// texture. All lie between 1 and 8, and are multiples of 2^-23.
using LogLevels = std::array<float, 256>;
const LogLevels& LogOfLevel();

}  // namespace freelsd
