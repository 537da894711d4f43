// Private to classification/. Logarithms of grey levels.
#pragma once

#include <array>

namespace freelsd {

// By level; levels are raised a little first, so that noise in shadows is not taken for texture.
// All lie between 1 and 8: they are multiples of 2^-23.
using LogLevels = std::array<float, 256>;
const LogLevels& LogOfLevel();

}  // namespace freelsd
