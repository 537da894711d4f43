#include "server/recall/site_lru.h"

#include <doctest/doctest.h>

namespace freelsd {
namespace {

TEST_CASE("site lru: one update of each site") {
  SiteLru<int> kept(100);
  kept.Keep("a", 5, 10, 1);
  REQUIRE(kept.Find("a", 5) != nullptr);
  CHECK(*kept.Find("a", 5) == 1);
  CHECK(*kept.Find("a") == 1);
  CHECK(kept.Find("a", 6) == nullptr);
  CHECK(kept.Find("b") == nullptr);
  kept.Keep("a", 6, 10, 2);
  CHECK(*kept.Find("a", 6) == 2);
  CHECK(kept.Find("a", 5) == nullptr);
  kept.Erase("a");
  CHECK(kept.Find("a") == nullptr);
}

TEST_CASE("site lru: an update after the clock was set back is another one") {
  SiteLru<int> kept(100);
  kept.Keep("a", 500, 10, 1);
  CHECK(kept.Find("a", 100) == nullptr);
  kept.Keep("a", 100, 10, 2);
  CHECK(*kept.Find("a", 100) == 2);
  CHECK(kept.Find("a", 500) == nullptr);
}

TEST_CASE("site lru: an earlier value of a site leaves its room") {
  SiteLru<int> kept(100);
  kept.Keep("b", 1, 40, 0);
  for (int i = 0; i < 10; ++i) kept.Keep("a", i, 60, i);
  CHECK(kept.Find("b") != nullptr);
  kept.Erase("a");
  kept.Erase("a");
  kept.Keep("c", 1, 60, 0);
  CHECK(kept.Find("b") != nullptr);
}

TEST_CASE("site lru: used longest ago goes first, what was kept last stays") {
  SiteLru<int> kept(100);
  kept.Keep("a", 1, 50, 1);
  kept.Keep("b", 1, 50, 2);
  CHECK(kept.Find("a") != nullptr);
  kept.Keep("c", 1, 50, 3);
  CHECK(kept.Find("b") == nullptr);
  CHECK(kept.Find("a") != nullptr);
  kept.Keep("d", 1, 1000, 4);
  CHECK(kept.Find("d") != nullptr);
  CHECK(kept.Find("a") == nullptr);
}

}  // namespace
}  // namespace freelsd
