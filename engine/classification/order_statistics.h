// Private to classification/. Order statistics without a full sort.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace freelsd {

// The values at three ascending ranks below values.size(), as after sorting. Fastest for values
// between -4 and 4 that differ in the third decimal.
std::array<float, 3> OfRanks(std::vector<float> values, const std::array<size_t, 3>& ranks);

}  // namespace freelsd
