#include "storage/box_cache.h"

#include <memory>
#include <set>

#include <doctest/doctest.h>

namespace freelsd {
namespace {

// A tall row, many short ones south and north of its southern edge, and one far to the north.
BoxCache<int>::Rows SomeRows() {
  BoxCache<int>::Rows rows;
  rows.push_back({{8.0, 50.0, 8.1, 50.5}, std::make_shared<const int>(-1)});
  for (int i = 0; i < 20; ++i) {
    const double south_deg = 49.8 + 0.05 * i;
    rows.push_back({{8.0, south_deg, 8.1, south_deg + 0.01}, std::make_shared<const int>(i)});
  }
  return rows;
}

TEST_CASE("box cache: what is kept gives the rows that meet a box, tall ones from far south too") {
  BoxCache<int> cache;
  int num_reads = 0;
  const auto read = [&](const BoundingBox& box) {
    ++num_reads;
    BoxCache<int>::Rows rows;
    for (const Boxed<int>& row : SomeRows()) {
      if (Meets(row.box, box)) rows.push_back(row);
    }
    return rows;
  };
  CHECK(cache.Within({7.0, 49.0, 9.0, 52.0}, 1, read).size() == 21);
  for (double south_deg = 49.7; south_deg < 50.8; south_deg += 0.013) {
    const BoundingBox box{8.02, south_deg, 8.04, south_deg + 0.004};
    std::multiset<int> expected, given;
    for (const Boxed<int>& row : SomeRows()) {
      if (Meets(row.box, box)) expected.insert(*row.row);
    }
    for (const auto& row : cache.Within(box, 1, read)) given.insert(*row);
    CAPTURE(south_deg);
    CHECK(given == expected);
  }
  CHECK(num_reads == 1);
  cache.Within({8.0, 50.0, 8.1, 50.1}, 2, read);
  CHECK(num_reads == 2);
}

TEST_CASE("box cache: boxes far apart are kept beside each other until rows change") {
  BoxCache<int> cache;
  int num_reads = 0;
  const auto read = [&](const BoundingBox& box) {
    ++num_reads;
    return BoxCache<int>::Rows{{box, std::make_shared<const int>(num_reads)}};
  };
  const auto ask = [&](double west_deg, uint64_t version) {
    return *cache.Within({west_deg, 50.0, west_deg + 0.1, 50.1}, version, read).at(0);
  };
  for (const int turn : {0, 1}) {
    CAPTURE(turn);
    CHECK(ask(0.0, 1) == 1);
    CHECK(ask(10.0, 1) == 2);
    CHECK(ask(20.0, 1) == 3);
  }
  // Near a kept one, a box is read that holds both.
  CHECK(ask(20.4, 1) == 4);
  CHECK(ask(20.0, 1) == 4);
  CHECK(ask(10.0, 2) == 5);
  CHECK(ask(10.0, 2) == 5);
  CHECK(ask(0.0, 2) == 6);
}

TEST_CASE("box cache: no more rows are kept than fit, and those last asked for stay") {
  BoxCache<int> cache;
  int num_reads = 0;
  const auto read = [&](const BoundingBox& box) {
    ++num_reads;
    return BoxCache<int>::Rows(40000, {box, std::make_shared<const int>(0)});
  };
  const auto ask = [&](double west_deg) {
    cache.Within({west_deg, 50.0, west_deg + 0.1, 50.1}, 1, read);
    return num_reads;
  };
  CHECK(ask(0.0) == 1);
  CHECK(ask(10.0) == 2);
  CHECK(ask(0.0) == 2);
  CHECK(ask(20.0) == 3);
  CHECK(ask(0.0) == 3);
  CHECK(ask(10.0) == 4);
}

}  // namespace
}  // namespace freelsd
