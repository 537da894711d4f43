#include "storage/obstacle_store.h"

#include <doctest/doctest.h>

#include "storage/storage.h"
#include "tests/storage/place.h"
#include "tests/storage/rows.h"

namespace freelsd {
namespace {

constexpr int64_t kNowUs = 1700000000000000;

ObstacleRow SomeObstacle(const std::string& id, const std::string& feature = R"({"a":1})") {
  return {id, feature, {7.0, 46.0, 8.0, 47.0}, std::nullopt, kNowUs};
}

TEST_CASE("obstacles: what is stored is found again after the next start, in every column") {
  const StoragePlace place;
  ObstacleRow people = SomeObstacle("people");
  people.expires_at_us = kNowUs + 5;
  { Storage(place.options()).obstacles.Put({SomeObstacle("wire"), people}, kNowUs); }
  const Storage storage(place.options());
  REQUIRE(storage.obstacles.List().size() == 2);
  CHECK(storage.obstacles.List()[0].id == "people");
  const auto found = storage.obstacles.Find("people");
  REQUIRE(found);
  CHECK(found->feature_json == people.feature_json);
  CHECK(found->box.west_deg == 7.0);
  CHECK(found->box.south_deg == 46.0);
  CHECK(found->box.east_deg == 8.0);
  CHECK(found->box.north_deg == 47.0);
  CHECK(found->expires_at_us == kNowUs + 5);
  CHECK(found->updated_at_us == kNowUs);
  CHECK_FALSE(storage.obstacles.Find("wire")->expires_at_us);
  CHECK_FALSE(storage.obstacles.Find("none"));
}

TEST_CASE("obstacles: the same id replaces, deletion removes, and each change has a new version") {
  const StoragePlace place;
  Storage storage(place.options());
  const uint64_t first = storage.obstacles.Version();
  storage.obstacles.Put({SomeObstacle("wire")}, kNowUs);
  const uint64_t second = storage.obstacles.Version();
  CHECK(second > first);
  storage.obstacles.Put({SomeObstacle("wire", R"({"a":2})")}, kNowUs);
  CHECK(storage.obstacles.Version() > second);
  CHECK(storage.obstacles.Find("wire")->feature_json == R"({"a":2})");
  CHECK(storage.obstacles.Delete("wire"));
  CHECK_FALSE(storage.obstacles.Delete("wire"));
  CHECK(storage.obstacles.List().empty());
}

TEST_CASE("obstacles: what was told removes and replaces nothing that is later by then") {
  const StoragePlace place;
  Storage storage(place.options());
  storage.obstacles.Put({SomeObstacle("wire")}, kNowUs);
  ObstacleRow told = SomeObstacle("wire", R"({"a":2})");
  const auto with_stamp = [&told](int64_t updated_at_us) {
    told.updated_at_us = updated_at_us;
    return told;
  };
  for (const bool is_from_above : {false, true}) {
    storage.obstacles.Merge({{with_stamp(kNowUs - 1)}, {{"wire", kNowUs - 1}}, is_from_above});
    CHECK(storage.obstacles.Find("wire")->feature_json == R"({"a":1})");
  }
  storage.obstacles.Merge({{with_stamp(kNowUs)}, {{"none", kNowUs}}, false});
  CHECK(storage.obstacles.Find("wire")->feature_json == R"({"a":2})");
  storage.obstacles.Merge({{}, {{"wire", kNowUs}}, true});
  CHECK(storage.obstacles.List().empty());
}

TEST_CASE("obstacles: the next write removes those that have expired") {
  const StoragePlace place;
  Storage storage(place.options());
  ObstacleRow people = SomeObstacle("people");
  people.expires_at_us = kNowUs + 5;
  storage.obstacles.Put({people}, kNowUs);
  storage.obstacles.Put({SomeObstacle("wire")}, kNowUs + 5);
  CHECK(storage.obstacles.List().size() == 2);
  storage.obstacles.Put({SomeObstacle("wire")}, kNowUs + 6);
  CHECK(storage.obstacles.List().size() == 1);
}

}  // namespace
}  // namespace freelsd
