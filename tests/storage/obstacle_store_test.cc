#include "storage/obstacle_store.h"

#include <filesystem>

#include <doctest/doctest.h>

#include "storage/storage.h"
#include "tests/storage/rows.h"
#include "tests/storage/sqlite/damage.h"

namespace freelsd {
namespace {

constexpr int64_t kNowUs = 1700000000000000;

ObstacleRow SomeObstacle(const std::string& id, const std::string& feature = R"({"a":1})") {
  return {id, feature, {7.0, 46.0, 8.0, 47.0}, std::nullopt, kNowUs};
}

TEST_CASE("obstacles: what is stored is found again after the next start, in every column") {
  const TemporaryFolder folder;
  ObstacleRow people = SomeObstacle("people");
  people.expires_at_us = kNowUs + 5;
  { Storage(folder.path()).obstacles.Put({SomeObstacle("wire"), people}, kNowUs); }
  const Storage storage(folder.path());
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
  const TemporaryFolder folder;
  Storage storage(folder.path());
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

TEST_CASE("obstacles: the next write removes those that have expired") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
  ObstacleRow people = SomeObstacle("people");
  people.expires_at_us = kNowUs + 5;
  storage.obstacles.Put({people}, kNowUs);
  storage.obstacles.Put({SomeObstacle("wire")}, kNowUs + 5);
  CHECK(storage.obstacles.List().size() == 2);
  storage.obstacles.Put({SomeObstacle("wire")}, kNowUs + 6);
  CHECK(storage.obstacles.List().size() == 1);
}

TEST_CASE("obstacles: they survive the loss of either file") {
  for (const char* const lost : {"freelsd.db", "recall.db"}) {
    CAPTURE(lost);
    const TemporaryFolder folder;
    { Storage(folder.path()).obstacles.Put({SomeObstacle("wire")}, kNowUs); }
    for (const char* const suffix : {"", "-wal", "-shm"}) {
      std::filesystem::remove(folder.path() / (lost + std::string(suffix)));
    }
    CHECK(Storage(folder.path()).obstacles.Find("wire"));
    // Once more: it is in both files again.
    const Storage storage(folder.path());
    CHECK(storage.obstacles.Find("wire"));
  }
}

TEST_CASE("obstacles: a change that reached the main database alone reaches the copy") {
  const TemporaryFolder folder;
  { Storage(folder.path()).obstacles.Put({SomeObstacle("wire")}, kNowUs); }
  // As if the process was killed between the two commits.
  Execute(folder.path() / "recall.db", "DELETE FROM obstacles");
  CHECK(Storage(folder.path()).obstacles.Find("wire"));
}

TEST_CASE("obstacles: a row that was changed outside counts as damage, the copy's is read") {
  const TemporaryFolder folder;
  { Storage(folder.path()).obstacles.Put({SomeObstacle("wire")}, kNowUs); }
  Execute(folder.path() / "recall.db", "UPDATE obstacles SET feature_json = '{}'");
  const Storage storage(folder.path());
  REQUIRE(storage.obstacles.Find("wire"));
  CHECK(storage.obstacles.Find("wire")->feature_json == R"({"a":1})");
  CHECK_FALSE(AwaitNotices(storage).empty());
}

}  // namespace
}  // namespace freelsd
