#include "storage/storage.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

#include "storage/migrations.h"
#include "tests/storage/rows.h"

namespace freelsd {
namespace {

size_t NumFiles(const std::filesystem::path& folder) {
  size_t count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    count += entry.is_regular_file() ? 1 : 0;
  }
  return count;
}

TEST_CASE("storage: what was stored is there after opening the folder again") {
  const TemporaryFolder folder;
  {
    Storage storage(folder.path());
    storage.InsertFlight(SomeFlight("f"));
    storage.WriteImage(kImage, std::string_view("pixels\0more", 11));
    storage.InsertFrames("f", {SomeFrame("f", "one"), SomeFrame("f", "two")}, SomeJob("j", "f"));
    storage.PutSite(SomeSite("f-r3", 50.0, 8.0), std::string("map\0blob", 8));
  }
  const Storage storage(folder.path());
  REQUIRE(storage.FindFlight("f"));
  CHECK(storage.FindFlight("f")->created_at_us == 1700000000000000);
  CHECK(storage.ReadImage(kImage) == std::string("pixels\0more", 11));
  CHECK(storage.ListFrames("f").size() == 2);
  CHECK(storage.ListFrames("f")[1].sequence == 2);
  CHECK(storage.FindJob("j")->kind == "batch");
  CHECK(storage.ReadSiteMap("f-r3") == std::string("map\0blob", 8));
}

TEST_CASE("storage: what the engine took of frames comes in their order, of those it took") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
  storage.InsertFlight(SomeFlight("f"));
  storage.WriteImage(kImage, "pixels");
  storage.InsertFrames("f", {SomeFrame("f", "z"), SomeFrame("f", "m"), SomeFrame("f", "a")});
  storage.ResolveFrame("f", "a", "{\"n\":3}");
  storage.ResolveFrame("f", "z", "{\"n\":1}");
  std::vector<std::string> taken;
  storage.ForEachResolved("f", [&taken](const std::string& json) { taken.push_back(json); });
  CHECK(taken == std::vector<std::string>{"{\"n\":1}", "{\"n\":3}"});
}

TEST_CASE("storage: a second process is refused while the folder is in use") {
  const TemporaryFolder folder;
  const Storage storage(folder.path());
  CHECK_THROWS_WITH_AS(
      Storage(folder.path()), doctest::Contains("another freelsd-server"), StorageError);
}

// Of every file below the folder.
std::map<std::string, std::string> BytesOf(const std::filesystem::path& folder) {
  std::map<std::string, std::string> bytes;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    bytes[entry.path()] = std::string(std::istreambuf_iterator<char>(file), {});
  }
  return bytes;
}

void MakeNewer(const std::filesystem::path& file) {
  const std::string sql =
      "PRAGMA user_version = " + std::to_string(kSchemaVersion + 1) +
      "; PRAGMA application_id = " + std::to_string(ApplicationId(kSchemaVersion + 1));
  Execute(file, sql.c_str());
}

TEST_CASE("storage: a newer program's folder is refused with a sentence, and left as it is") {
  // Of both files, or of the one that it came to before it was killed.
  const std::vector<std::vector<std::string>> cases{
      {"freelsd.db", "recall.db"}, {"freelsd.db"}, {"recall.db"}};
  for (const std::vector<std::string>& newer : cases) {
    CAPTURE(newer.size());
    CAPTURE(newer[0]);
    const TemporaryFolder folder;
    {
      Storage storage(folder.path());
      storage.InsertFlight(SomeFlight("f"));
      storage.PutSite(SomeSite("f-r3", 50.0, 8.0), "map");
    }
    std::ofstream(folder.path() / "damaged") << "so a newer program said";
    for (const std::string& name : newer) MakeNewer(folder.path() / name);
    const std::map<std::string, std::string> before = BytesOf(folder.path());
    try {
      const Storage storage(folder.path());
      FAIL("it was opened");
    } catch (const StorageError& error) {
      CHECK(error.fault == StorageFault::kNewer);
      CHECK(std::string(error.what()).find("a newer freelsd wrote it") != std::string::npos);
    }
    CHECK((BytesOf(folder.path()) == before));
  }
}

TEST_CASE("storage: of a newer program's database that is spoilt or gone, its copy is left") {
  for (const bool is_gone : {false, true}) {
    const TemporaryFolder folder;
    { Storage(folder.path()).PutSite(SomeSite("f-r3", 50.0, 8.0), "map"); }
    MakeNewer(folder.path() / "recall.db");
    std::filesystem::resize_file(folder.path() / "freelsd.db", 50);
    if (is_gone) std::filesystem::remove(folder.path() / "freelsd.db");
    const std::map<std::string, std::string> before = BytesOf(folder.path());
    CHECK_THROWS_AS(Storage(folder.path()), StorageError);
    CHECK((BytesOf(folder.path()) == before));
  }
}

TEST_CASE("storage: two files of a higher version are refused, whatever they say besides") {
  const TemporaryFolder folder;
  { const Storage storage(folder.path()); }
  Execute(folder.path() / "freelsd.db", "PRAGMA user_version = 4");
  Execute(folder.path() / "recall.db", "PRAGMA user_version = 4");
  CHECK_THROWS_WITH_AS(Storage(folder.path()), doctest::Contains("version 4"), StorageError);
}

// What version 1 had of sites, with one of each verdict.
constexpr char kVersion1[] = R"sql(
CREATE TABLE flights (id TEXT PRIMARY KEY, name TEXT NOT NULL, request_json TEXT NOT NULL,
  rig_json TEXT NOT NULL, warnings_json TEXT NOT NULL, stages_json TEXT NOT NULL,
  created_at_us INTEGER NOT NULL, num_rejected_frames INTEGER NOT NULL, has_failed INTEGER NOT NULL,
  ground_altitude_m REAL) STRICT;
CREATE TABLE frames (flight_id TEXT NOT NULL REFERENCES flights (id) ON DELETE CASCADE,
  sequence INTEGER NOT NULL, id TEXT NOT NULL, sha256 TEXT NOT NULL, meta_json TEXT NOT NULL,
  state INTEGER NOT NULL, reason TEXT NOT NULL, is_from_batch INTEGER NOT NULL,
  PRIMARY KEY (flight_id, id)) STRICT, WITHOUT ROWID;
CREATE TABLE sites (id TEXT PRIMARY KEY, flight_id TEXT NOT NULL, region_id INTEGER NOT NULL,
  latitude_deg REAL NOT NULL, longitude_deg REAL NOT NULL, feature_json TEXT NOT NULL,
  approach_json TEXT NOT NULL, replan_json TEXT NOT NULL, updated_at_us INTEGER NOT NULL) STRICT;
CREATE TABLE site_maps (site_id TEXT PRIMARY KEY REFERENCES sites (id) ON DELETE CASCADE,
  map BLOB NOT NULL) STRICT;
INSERT INTO sites VALUES ('good', 'f', 1, 50.0, 8.0, '{"properties":{"verdict":"landable",
  "elevation_m":312.5,"score":0.7,"altitude_datum":"amsl","aircraft":{"profile":"small"}}}',
  '', '{}', 5);
INSERT INTO sites VALUES ('bad', 'f', 2, 50.0, 8.0, '{"properties":{"verdict":"rejected",
  "elevation_m":312.5,"score":0.1}}', '', '{}', 5);
INSERT INTO sites VALUES ('odd', 'f', 3, 50.0, 8.0, '{"properties":{"verdict":"landable",
  "elevation_m":null}}', '', '{}', 5);
PRAGMA user_version = 1;
)sql";

TEST_CASE("storage: version 1 is brought up, and only what is known to be good is recalled") {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path());
  Execute(folder.path() / "freelsd.db", kVersion1);
  for (int i = 0; i < 2; ++i) {
    const Storage storage(folder.path());
    const SharedRows<RecallRow> rows = storage.ListRecallable({7.0, 49.0, 9.0, 51.0});
    REQUIRE(rows.size() == 1);
    CHECK(rows[0]->site_id == "good");
    CHECK(rows[0]->data.is_landable);
    CHECK(rows[0]->data.altitude_m == 312.5);
    CHECK(rows[0]->data.altitude_datum == "amsl");
    CHECK(rows[0]->data.aircraft_json.find("small") != std::string::npos);
    CHECK(storage.ListMaps({7.0, 49.0, 9.0, 51.0}).size() == 3);
  }
}

TEST_CASE(
    "storage: recall finds sites by box, also over the antimeridian, and forgets deleted ones") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
  SiteRow site = SomeSite("fiji", -17.0, 179.95);
  site.recall = RecallData{true, 10.0, "amsl", 0.5, "{}"};
  storage.PutSite(site, "");
  site = SomeSite("taveuni", -17.0, -179.9);
  site.recall = RecallData{false, 20.0, "amsl", 0.4, "{}"};
  site.map_box = BoundingBox{-179.95, -17.1, -179.5, -16.9};
  storage.PutSite(site, "map");
  storage.PutSite(SomeSite("rejected", -17.0, 179.95), "");
  CHECK(storage.ListRecallable({179.9, -18.0, -179.8, -16.0}).size() == 2);
  CHECK(storage.ListRecallable({179.0, -18.0, 180.0, -16.0}).size() == 1);
  // By the map's extent, not the touchdown.
  CHECK(storage.ListRecallable({-179.6, -18.0, -179.4, -16.0}).size() == 1);
  CHECK(storage.ListRecallable({0.0, -18.0, 10.0, -16.0}).empty());
  CHECK(storage.ListMaps({179.9, -18.0, 180.0, -16.0}).size() == 2);
  // Rejected at the next evaluation: no longer recalled.
  site.recall.reset();
  storage.PutSite(site, "map");
  CHECK(storage.ListRecallable({-180.0, -90.0, 180.0, 90.0}).size() == 1);
  storage.DeleteSite("fiji");
  CHECK(storage.ListRecallable({-180.0, -90.0, 180.0, 90.0}).empty());
  CHECK(storage.ListMaps({-180.0, -90.0, 180.0, 90.0}).size() == 2);
}

TEST_CASE("storage: frames of a refused insert are not there, nor is their job") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
  storage.InsertFlight(SomeFlight("f"));
  storage.WriteImage(kImage, "pixels");
  storage.InsertFrames("f", {SomeFrame("f", "one")});
  CHECK_THROWS_AS(
      storage.InsertFrames("f", {SomeFrame("f", "two"), SomeFrame("f", "one")}, SomeJob("j", "f")),
      StorageError);
  CHECK(storage.ListFrames("f").size() == 1);
  CHECK_FALSE(storage.FindJob("j"));
}

TEST_CASE("storage: a frame without its image file is refused") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
  storage.InsertFlight(SomeFlight("f"));
  CHECK_THROWS_AS(storage.InsertFrames("f", {SomeFrame("f", "one")}), StorageError);
  CHECK(storage.ListFrames("f").empty());
}

TEST_CASE("storage: frames are counted by state and taken in order") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
  storage.InsertFlight(SomeFlight("f"));
  storage.WriteImage(kImage, "pixels");
  storage.InsertFrames("f", {SomeFrame("f", "b"), SomeFrame("f", "a"), SomeFrame("f", "c")});
  CHECK(storage.CountQueuedFrames() == 3);
  CHECK(storage.NextFrame("f", 0)->id == "b");
  CHECK(storage.NextFrame("f", 1)->id == "a");
  storage.SetFrameState("f", "b", FrameState::kProcessed, "");
  storage.SetFrameState("f", "a", FrameState::kRejected, "too dark");
  const Storage::FrameCounts counts = storage.CountFrames("f");
  CHECK(counts.received == 3);
  CHECK(counts.processed == 1);
  CHECK(counts.rejected == 1);
  CHECK(storage.FindFrame("f", "a")->reason == "too dark");
  CHECK(storage.FlightsWithQueuedFrames() == std::vector<std::string>{"f"});
  CHECK(storage.NextQueuedSequence("f", 0) == 3);
  CHECK_FALSE(storage.NextQueuedSequence("f", 3));
  CHECK_FALSE(storage.NextFrame("f", 3));
}

TEST_CASE("storage: deleting a flight keeps its sites and the images that another flight needs") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
  FrameRow own = SomeFrame("f", "own");
  own.sha256 = kOtherImage;
  storage.InsertFlight(SomeFlight("f"));
  storage.InsertFlight(SomeFlight("g"));
  storage.WriteImage(kImage, "shared");
  storage.WriteImage(kOtherImage, "own");
  storage.InsertFrames("f", {SomeFrame("f", "one"), own}, SomeJob("j", "f"));
  storage.InsertFrames("g", {SomeFrame("g", "one")});
  storage.PutSite(SomeSite("f-r3", 50.0, 8.0), "map");
  CHECK(storage.DeleteFlight("f", false));
  CHECK_FALSE(storage.DeleteFlight("f", false));
  CHECK(storage.ListFrames("f").empty());
  CHECK_FALSE(storage.FindJob("j"));
  CHECK(storage.ReadImage(kImage) == "shared");
  CHECK_FALSE(storage.ReadImage(kOtherImage));
  CHECK(storage.FindSite("f-r3"));
}

TEST_CASE("storage: an image that was written for nothing can be taken back") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
  storage.InsertFlight(SomeFlight("f"));
  storage.WriteImage(kImage, "used");
  storage.WriteImage(kOtherImage, "unused");
  storage.InsertFrames("f", {SomeFrame("f", "one")});
  storage.RemoveUnusedImage(kImage);
  storage.RemoveUnusedImage(kOtherImage);
  CHECK(storage.ReadImage(kImage) == "used");
  CHECK_FALSE(storage.ReadImage(kOtherImage));
}

TEST_CASE("storage: deleting a flight forgets its sites when asked") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
  storage.InsertFlight(SomeFlight("f"));
  storage.PutSite(SomeSite("f-r3", 50.0, 8.0), "map");
  CHECK(storage.DeleteFlight("f", true));
  CHECK_FALSE(storage.FindSite("f-r3"));
  CHECK_FALSE(storage.ReadSiteMap("f-r3"));
}

TEST_CASE("storage: image files that no frame names are removed at start") {
  const TemporaryFolder folder;
  {
    Storage storage(folder.path());
    storage.InsertFlight(SomeFlight("f"));
    storage.WriteImage(kImage, "kept");
    storage.WriteImage(kOtherImage, "left by a crash");
    storage.InsertFrames("f", {SomeFrame("f", "one")});
  }
  const Storage storage(folder.path());
  CHECK(NumFiles(folder.path() / "images") == 1);
  CHECK(storage.ReadImage(kImage) == "kept");
}

TEST_CASE("storage: sites are found by box, also across the antimeridian") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
  storage.PutSite(SomeSite("home", 50.0, 8.0), "");
  storage.PutSite(SomeSite("fiji", -17.0, 179.5), "");
  storage.PutSite(SomeSite("taveuni", -17.0, -179.9), "");
  CHECK(storage.ListSites(std::nullopt, std::nullopt).size() == 3);
  CHECK(storage.ListSites(std::nullopt, BoundingBox{7.0, 49.0, 9.0, 51.0}).size() == 1);
  CHECK(storage.ListSites(std::nullopt, BoundingBox{179.0, -18.0, -179.0, -16.0}).size() == 2);
  CHECK(storage.ListSites("g", std::nullopt).empty());
  CHECK(storage.ListSites("f", std::nullopt).size() == 3);
}

TEST_CASE("storage: a site put again replaces its map, an empty one removes it") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
  storage.PutSite(SomeSite("s", 50.0, 8.0), "old");
  SiteRow site = SomeSite("s", 51.0, 8.0);
  site.approach_json = "{}";
  storage.PutSite(site, "new");
  CHECK(storage.ReadSiteMap("s") == "new");
  CHECK(storage.FindSite("s")->latitude_deg == 51.0);
  CHECK(storage.FindSite("s")->approach_json == "{}");
  storage.PutSite(site, "");
  CHECK_FALSE(storage.ReadSiteMap("s"));
  CHECK(storage.DeleteSite("s"));
  CHECK_FALSE(storage.DeleteSite("s"));
}

TEST_CASE("storage: a finished job is not changed any more") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
  storage.InsertFlight(SomeFlight("f"));
  JobRow job = SomeJob("j", "f");
  storage.InsertJob(job);
  CHECK(storage.ListUnfinishedJobs().size() == 1);
  job.state = JobState::kCancelled;
  storage.UpdateJob(job);
  job.state = JobState::kDone;
  storage.UpdateJob(job);
  CHECK(storage.FindJob("j")->state == JobState::kCancelled);
  CHECK(storage.ListUnfinishedJobs().empty());
  CHECK(storage.ListJobs().size() == 1);
  CHECK(storage.DeleteJob("j"));
}

TEST_CASE("storage: regions are replaced as one snapshot and keep their order") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
  storage.InsertFlight(SomeFlight("f"));
  storage.ReplaceRegions("f", {{7, "seven", "h7"}, {2, "two", "h2"}});
  storage.ReplaceRegions("f", {{9, "nine", "h9"}, {7, "seven", "h7"}});
  const std::vector<Storage::RegionRow> regions = storage.ListRegions("f");
  REQUIRE(regions.size() == 2);
  CHECK(regions[0].id == 9);
  CHECK(regions[1].feature_json == "seven");
  CHECK(regions[1].history_json == "h7");
}

TEST_CASE("storage: changes of one flight from several threads are all kept") {
  constexpr int kNumThreads = 4;
  constexpr int kNumChanges = 20;
  const TemporaryFolder folder;
  Storage storage(folder.path());
  storage.InsertFlight(SomeFlight("f"));
  std::vector<std::thread> threads;
  for (int i = 0; i < kNumThreads; ++i) {
    threads.emplace_back([&storage] {
      for (int k = 0; k < kNumChanges; ++k) {
        storage.ChangeFlight("f", [](FlightRow& flight) { ++flight.num_rejected_frames; });
        storage.FindFlight("f");
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(storage.FindFlight("f")->num_rejected_frames == kNumThreads * kNumChanges);
  CHECK_FALSE(storage.ChangeFlight("g", [](FlightRow&) {}));
}

TEST_CASE("storage: text that looks like SQL is data") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
  FlightRow flight = SomeFlight("f");
  flight.name = "'); DROP TABLE flights; --";
  storage.InsertFlight(flight);
  CHECK(storage.FindFlight("f")->name == flight.name);
  CHECK_FALSE(storage.FindFlight("' OR '1' = '1"));
}

TEST_CASE("storage: a fresh folder can be written") {
  const TemporaryFolder folder;
  const Storage storage(folder.path());
  CHECK_FALSE(storage.WhyNotWritable());
  CHECK(std::filesystem::is_empty(storage.SpoolFolder()));
}

}  // namespace
}  // namespace freelsd
