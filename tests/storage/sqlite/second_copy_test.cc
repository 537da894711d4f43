#include <filesystem>
#include <set>
#include <string>
#include <utility>

#include <doctest/doctest.h>

#include "storage/storage.h"
#include "tests/storage/antimeridian.h"
#include "tests/storage/rows.h"
#include "tests/storage/small_disk.h"
#include "tests/storage/sqlite/damage.h"

namespace freelsd {
namespace {

constexpr BoundingBox kHere{8.0, 50.0, 8.01, 50.01};

// All comes from the copy then.
void LoseMainDatabase(const TemporaryFolder& folder) {
  std::filesystem::remove(folder.path() / "freelsd.db");
  std::filesystem::remove(folder.path() / "freelsd.db-wal");
}

TEST_CASE("maps: an evaluation replaces sites and maps in one commit, in both databases") {
  const TemporaryFolder folder;
  {
    Storage storage(folder.path());
    storage.maps.Stage(SomeMap("f/1", "f", kHere), {{{0, 0, 0}, "old"}}, {});
    storage.sites.PutEvaluation({{SomeSite("f-r1", 50.0, 8.0)}, {}, {"f/1"}, {}}, {});
    storage.maps.Stage(SomeMap(storage.maps.NewId("f"), "f", kHere), {{{0, 0, 0}, "new"}}, {});
    storage.sites.PutEvaluation({{SomeSite("f-r2", 50.0, 8.0)}, {"f-r1"}, {"f/2"}, {"f/1"}}, {});
    CHECK(storage.maps.NewId("f") == "f/3");
  }
  LoseMainDatabase(folder);
  const Storage storage(folder.path());
  CHECK_FALSE(storage.sites.Find("f-r1"));
  CHECK(storage.sites.Find("f-r2"));
  REQUIRE(storage.maps.ListOf("f").size() == 1);
  CHECK(storage.maps.ReadTile("f/2", {0, 0, 0}) == "new");
  CHECK_FALSE(storage.maps.ReadTile("f/1", {0, 0, 0}));
}

TEST_CASE("maps: a map across the antimeridian is found in the copy too, and nowhere else") {
  const TemporaryFolder folder;
  {
    Storage storage(folder.path());
    PutAcross(storage);
  }
  LoseMainDatabase(folder);
  CheckFoundAcross(Storage(folder.path()));
}

constexpr int64_t kNowUs = 1700000000000000;

ObstacleRow SomeObstacle(const std::string& id, const std::string& feature = R"({"a":1})") {
  return {id, feature, {7.0, 46.0, 8.0, 47.0}, std::nullopt, kNowUs};
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

TEST_CASE("second copy: a change of the same stamp reaches the copy after a kill, too") {
  const TemporaryFolder folder;
  const std::filesystem::path copy = folder.path() / "recall.db";
  {
    Storage storage(folder.path());
    PutSite(storage, SomeSite("s", 50.0, 8.0));
  }
  std::filesystem::copy_file(copy, folder.path() / "former");
  SiteRow changed = SomeSite("s", 50.0, 8.0);
  changed.feature_json = R"({"changed":1})";
  {
    Storage storage(folder.path());
    PutSite(storage, changed);
  }
  // The process was killed between the two commits.
  std::filesystem::rename(folder.path() / "former", copy);
  { const Storage storage(folder.path()); }
  LoseMainDatabase(folder);
  CHECK(Storage(folder.path()).sites.Find("s")->feature_json == changed.feature_json);
}

TEST_CASE("second copy: what a full disk refuses is in neither database") {
  const TemporaryFolder folder;
  const SmallDisk disk(folder.path() / "disk", "8m");
  if (!IsMounted(disk)) return;
  const auto name = [](int i) { return "mast-" + std::to_string(i); };
  int num_refused = 0;
  std::set<std::string> accepted;
  {
    Storage storage(folder.path() / "disk");
    for (int i = 0; i < 60; ++i) {
      disk.Fill(static_cast<uint64_t>(i) * 4096);
      try {
        storage.obstacles.Put({SomeObstacle(name(i))}, kNowUs);
        accepted.insert(name(i));
      } catch (const StorageError& error) {
        CHECK(error.fault == StorageFault::kFull);
        CHECK_FALSE(storage.obstacles.Find(name(i)));
        ++num_refused;
      }
    }
    disk.MakeRoom();
  }
  CHECK(num_refused > 0);
  REQUIRE_FALSE(accepted.empty());
  for (const bool is_main_lost : {false, true}) {
    CAPTURE(is_main_lost);
    if (is_main_lost) Spoil(folder.path() / "disk/freelsd.db", 0, 4096);
    std::set<std::string> stored;
    for (const auto& obstacle : Storage(folder.path() / "disk").obstacles.List()) {
      stored.insert(obstacle.id);
    }
    CHECK(stored == accepted);
  }
}

TEST_CASE("second copy: without room to restore it, recall reads it, and a later start restores") {
  const TemporaryFolder folder;
  const SmallDisk disk(folder.path() / "disk", "8m");
  if (!IsMounted(disk)) return;
  const std::filesystem::path data = folder.path() / "disk";
  {
    Storage storage(data);
    storage.maps.Stage(SomeMap("f/1", "f", kHere), {{{0, 0, 0}, std::string(900000, 'm')}}, {});
    storage.sites.PutEvaluation({{SomeSite("f-r1", 50.0, 8.0)}, {}, {"f/1"}, {}}, {});
  }
  Spoil(data / "freelsd.db", 0, 4096);
  disk.Fill(uint64_t{700} << 10);
  {
    const Storage storage(data);
    CHECK(storage.sites.Find("f-r1"));
    CHECK(storage.WhyNotWritable());
    CHECK_FALSE(storage.Notices().empty());
  }
  disk.MakeRoom();
  const Storage storage(data);
  CHECK(storage.sites.Find("f-r1"));
  CHECK(storage.maps.ReadTile("f/1", {0, 0, 0})->size() == 900000);
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

TEST_CASE(
    "feed: a database that was put back tells another feed, and gives no map's number again") {
  const TemporaryFolder folder;
  const auto open = [&folder] {
    Storage storage(folder.path());
    return std::pair(storage.changes.FeedId(), storage.maps.NewId("f"));
  };
  const auto first = open();
  CHECK(first.second == "f/1");
  CHECK(open() == first);
  std::filesystem::copy_file(folder.path() / "freelsd.db", folder.path() / "backup");
  std::filesystem::rename(folder.path() / "backup", folder.path() / "freelsd.db");
  const auto second = open();
  CHECK(second.first != first.first);
  CHECK(second.second == "f/1000001");
  CHECK(open() == second);
}

}  // namespace
}  // namespace freelsd
