#include "engine/classification/order_statistics.h"

#include <algorithm>
#include <cstdint>

namespace freelsd {
namespace {

constexpr size_t kNumBins = 8192;
constexpr float kBinsPerUnit = 1024.0f;

// Monotonic in the value.
size_t BinOf(float value) {
  constexpr float kZeroBin = 0.5f * kNumBins;
  return static_cast<size_t>(
      static_cast<int>(std::clamp(value * kBinsPerUnit + kZeroBin, 0.0f, kNumBins - 1.0f)));
}

}  // namespace

std::array<float, 3> OfRanks(std::vector<float> values, const std::array<size_t, 3>& ranks) {
  std::vector<uint32_t> counts(kNumBins, 0);
  for (const float value : values) ++counts[BinOf(value)];
  // Drops values of bins that hold none of the ranks.
  std::vector<uint8_t> is_kept(kNumBins, 0);
  std::array<size_t, 3> kept_ranks{};
  size_t num_values = 0, num_left_out = 0, next = 0;
  for (size_t bin = 0; bin < kNumBins; ++bin) {
    num_values += counts[bin];
    for (; next < ranks.size() && ranks[next] < num_values; ++next) {
      kept_ranks[next] = ranks[next] - num_left_out;
      is_kept[bin] = 1;
    }
    if (is_kept[bin] == 0) num_left_out += counts[bin];
  }
  size_t num_kept = 0;
  for (const float value : values) {
    values[num_kept] = value;
    num_kept += is_kept[BinOf(value)];
  }
  values.resize(num_kept);
  std::array<float, 3> result{};
  auto first = values.begin();
  for (size_t i = 0; i < result.size(); ++i) {
    // Values left of an earlier rank stay there.
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(kept_ranks[i]);
    std::nth_element(first, at, values.end());
    first = at;
    result[i] = *at;
  }
  return result;
}

}  // namespace freelsd
