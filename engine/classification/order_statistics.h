// Private to classification/. Order statistics without a full sort.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace freelsd {

// The values that would have these ranks after sorting. The ranks are ascending and less than
// values.size(). Fastest if the values lie between -4 and 4 and differ by about 0.001 or more.
std::array<float, 3> OfRanks(std::vector<float> values, const std::array<size_t, 3>& ranks);

}  // namespace freelsd
