// Private to classification/. Values at given places of an order that is not made.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace freelsd {

// What values[rank] would be after sorting, for three ascending ranks below values.size(). Fastest
// for values between -4 and 4 that differ in the third decimal.
std::array<float, 3> OfRanks(std::vector<float> values, const std::array<size_t, 3>& ranks);

}  // namespace freelsd
