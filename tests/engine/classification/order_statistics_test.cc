#include "engine/classification/order_statistics.h"

#include <algorithm>
#include <random>

#include <doctest/doctest.h>

namespace freelsd {
namespace {

void CheckAgainstSorting(const std::vector<float>& values, const std::array<size_t, 3>& ranks) {
  std::vector<float> sorted = values;
  std::sort(sorted.begin(), sorted.end());
  const std::array<float, 3> result = OfRanks(values, ranks);
  for (size_t i = 0; i < ranks.size(); ++i) {
    CAPTURE(values.size());
    CAPTURE(ranks[i]);
    CHECK(result[i] == sorted[ranks[i]]);
  }
}

TEST_CASE("order statistics: what sorting gives, however values are spread") {
  std::mt19937 generator(7);
  for (const float deviation : {0.0f, 1e-6f, 0.05f, 1.0f, 30.0f}) {
    for (const size_t count : {1, 2, 3, 10, 777, 20000}) {
      std::vector<float> values;
      for (size_t i = 0; i < count; ++i) {
        // Between -2 and 2.
        values.push_back(deviation * (static_cast<float>(generator() >> 8) * 0x1p-22f - 2.0f));
      }
      CheckAgainstSorting(values, {0, count / 2, count - 1});
      CheckAgainstSorting(values, {count / 20, count / 2, count - 1 - count / 20});
      CheckAgainstSorting(values, {count / 3, count / 3, count / 3});
    }
  }
}

TEST_CASE("order statistics: equal values, two kinds of values, and values far outside") {
  CheckAgainstSorting(std::vector<float>(100, 0.25f), {0, 50, 99});
  std::vector<float> values(60, -0.5f);
  values.resize(100, 0.5f);
  CheckAgainstSorting(values, {59, 60, 99});
  CheckAgainstSorting({1e30f, -1e30f, 0.0f, 5.0f, 4.5f, -4.5f}, {0, 3, 5});
}

}  // namespace
}  // namespace freelsd
