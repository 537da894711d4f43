#include "storage/sqlite/migrations.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "storage/sqlite/sqlite.h"
#include "storage/storage.h"
#include "tests/storage/rows.h"
#include "tests/storage/sqlite/damage.h"

namespace freelsd {
namespace {

std::string BytesOfFile(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(stream), {});
}

// Of every file below the folder.
std::map<std::string, std::string> BytesOf(const std::filesystem::path& folder) {
  std::map<std::string, std::string> bytes;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    bytes[entry.path()] = BytesOfFile(entry.path());
  }
  return bytes;
}

void MakeNewer(const std::filesystem::path& file) {
  const std::string sql =
      "PRAGMA user_version = " + std::to_string(kSchemaVersion + 1) +
      "; PRAGMA application_id = " + std::to_string(ApplicationId(kSchemaVersion + 1));
  Execute(file, sql.c_str());
}

TEST_CASE("migrations: a newer program's folder is refused with a sentence, and left as it is") {
  // Of both files, or of the one that it came to before it was killed.
  const std::vector<std::vector<std::string>> cases{
      {"freelsd.db", "recall.db"}, {"freelsd.db"}, {"recall.db"}};
  for (const std::vector<std::string>& newer : cases) {
    CAPTURE(newer.size());
    CAPTURE(newer[0]);
    const TemporaryFolder folder;
    {
      Storage storage(folder.path());
      storage.flights.Insert(SomeFlight("f"));
      storage.sites.Put(SomeSite("f-r3", 50.0, 8.0), "map");
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

TEST_CASE("migrations: of a newer program's database that is spoilt or gone, its copy is left") {
  for (const bool is_gone : {false, true}) {
    const TemporaryFolder folder;
    { Storage(folder.path()).sites.Put(SomeSite("f-r3", 50.0, 8.0), "map"); }
    MakeNewer(folder.path() / "recall.db");
    std::filesystem::resize_file(folder.path() / "freelsd.db", 50);
    if (is_gone) std::filesystem::remove(folder.path() / "freelsd.db");
    const std::map<std::string, std::string> before = BytesOf(folder.path());
    CHECK_THROWS_AS(Storage(folder.path()), StorageError);
    CHECK((BytesOf(folder.path()) == before));
  }
}

TEST_CASE("migrations: two files of a higher version are refused, whatever they say besides") {
  const TemporaryFolder folder;
  { const Storage storage(folder.path()); }
  const std::string newer = std::to_string(kSchemaVersion + 1);
  const std::string sql = "PRAGMA user_version = " + newer;
  Execute(folder.path() / "freelsd.db", sql.c_str());
  Execute(folder.path() / "recall.db", sql.c_str());
  CHECK_THROWS_WITH_AS(
      Storage(folder.path()), doctest::Contains(("version " + newer).c_str()), StorageError);
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

TEST_CASE("migrations: version 1 is brought up, and only what is known to be good is recalled") {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path());
  Execute(folder.path() / "freelsd.db", kVersion1);
  for (int i = 0; i < 2; ++i) {
    const Storage storage(folder.path());
    const SharedRows<RecallRow> rows = storage.sites.ListRecallable({7.0, 49.0, 9.0, 51.0});
    REQUIRE(rows.size() == 1);
    CHECK(rows[0]->site_id == "good");
    CHECK(rows[0]->data.is_landable);
    CHECK(rows[0]->data.altitude_m == 312.5);
    CHECK(rows[0]->data.altitude_datum == "amsl");
    CHECK(rows[0]->data.aircraft_json.find("small") != std::string::npos);
    CHECK(storage.sites.ListMaps({7.0, 49.0, 9.0, 51.0}).size() == 3);
  }
}

// One line for each column and index of a closed database.
std::vector<std::string> SchemaOf(const std::filesystem::path& file) {
  const Connection database(file, Access::kRead);
  Statement statement = database.Prepare(
      "SELECT entry.name || ' ' || coalesce(cid || ' ' || column.name || ' ' || column.type || "
      "' ' || \"notnull\" || ' ' || coalesce(dflt_value, ''), '') AS line "
      "FROM sqlite_schema AS entry LEFT JOIN pragma_table_info(entry.name) AS column ORDER BY "
      "line");
  std::vector<std::string> schema;
  while (statement.Step()) schema.push_back(statement.Text(0));
  return schema;
}

// A folder with both files as 0.1.0 wrote them.
void WriteVersion3(const std::filesystem::path& folder) {
  const std::string sql = BytesOfFile(std::filesystem::path(FREELSD_TEST_SOURCE_DIR) /
                                      "tests/storage/sqlite/version_3.sql");
  for (const char* const name : {"freelsd.db", "recall.db"}) Execute(folder / name, sql.c_str());
}

TEST_CASE("migrations: a database of 0.1.0 is served, flights and sites alike") {
  const TemporaryFolder folder;
  WriteVersion3(folder.path());
  const Storage storage(folder.path());
  REQUIRE(storage.flights.Find("f"));
  CHECK(storage.flights.Find("f")->ground_altitude_m == 12.5);
  CHECK(storage.flights.ListRegions("f").at(0).id == 7);
  CHECK(storage.flights.ListWithQueuedFrames() == std::vector<std::string>{"f"});
  REQUIRE(storage.frames.List("f").size() == 2);
  CHECK(storage.frames.List("f")[0].resolved_json == "{\"r\":1}");
  CHECK(storage.frames.List("f")[1].is_from_batch);
  CHECK(storage.jobs.ListUnfinished().size() == 1);
  CHECK(storage.telemetry.Around("f", TelemetryKind::kPosition, 11).before->values[2] == 400.0);
  CHECK(storage.sites.List(std::nullopt, std::nullopt).size() == 3);
  CHECK(storage.sites.Find("f-r1")->superseded_by == "g-r1");
  CHECK(storage.sites.ReadMap("f-r1") == std::string("map\0x", 5));
  const SharedRows<RecallRow> rows = storage.sites.ListRecallable({7.0, 49.0, 9.0, 51.0});
  REQUIRE(rows.size() == 1);
  CHECK(rows[0]->site_id == "g-r1");
  // A checksum that was computed in another way would count as damage.
  CHECK(storage.Notices().empty());
}

TEST_CASE("migrations: a database of 0.1.0 is brought up in both files, its sites to be checked") {
  const TemporaryFolder folder;
  WriteVersion3(folder.path());
  {
    Storage storage(folder.path());
    CHECK(storage.sites.ListUnchecked() == std::vector<std::string>{"f-r1", "g-r1"});
    CHECK(storage.sites.Find("f-r1")->superseded_reason.empty());
    storage.flights.Insert(SomeFlight("h"));
    storage.sites.Put(SomeSite("h-r1", 50.2, 8.0), "map");
  }
}

TEST_CASE("migrations: maps of rejected sites take their datum from the stored replan data") {
  const TemporaryFolder folder;
  WriteVersion3(folder.path());
  constexpr char kRejected[] = R"sql(
INSERT INTO sites VALUES
  ('a', 'f', 4, 51.0, 8.0, '{}', '', '{"flight":"{\"altitude_datum\":\"amsl\"}"}', 0, NULL, NULL, 0, 0),
  ('b', 'f', 5, 51.0, 8.0, '{}', '', '{"flight":"{\"altitude_datum\":\"ellipsoid\"}"}', 0, NULL, NULL, 0, 0),
  ('c', 'f', 6, 51.0, 8.0, '{}', '', '{"flight":"{\"name\":\"x\"}"}', 0, NULL, NULL, 0, 0),
  ('d', 'f', 7, 51.0, 8.0, '{}', '', '{"flight":"{"}', 0, NULL, NULL, 0, 0),
  ('e', 'f', 8, 51.0, 8.0, '{}', '', 'no JSON', 0, NULL, NULL, 0, 0);
INSERT INTO site_numbers
  SELECT region_id, id, 0, 0, 0.0, 'unknown', 0.0, '{}', NULL FROM sites WHERE region_id > 3;
INSERT INTO site_boxes SELECT number, 8.0, 8.0, 51.0, 51.0 FROM site_numbers WHERE number > 3;
)sql";
  Execute(folder.path() / "freelsd.db", kRejected);
  const Storage storage(folder.path());
  std::map<std::string, std::string> datums;
  for (const auto& map : storage.sites.ListMaps({7.0, 50.5, 9.0, 51.5})) {
    datums[map->id] = map->altitude_datum;
    CHECK(map->flight_id == "f");
  }
  CHECK((datums == std::map<std::string, std::string>{{"a", "amsl"},
                                                      {"b", "ellipsoid"},
                                                      {"c", "unknown"},
                                                      {"d", "unknown"},
                                                      {"e", "unknown"}}));
  CHECK(storage.Notices().empty());
}

TEST_CASE("migrations: a database of 0.1.0 gets the columns and indices of a new one") {
  const TemporaryFolder folder, fresh;
  WriteVersion3(folder.path());
  for (const TemporaryFolder* const each : {&folder, &fresh}) {
    Storage storage(each->path());
    storage.flights.Insert(SomeFlight("h"));
    storage.sites.Put(SomeSite("h-r1", 50.2, 8.0), "map");
  }
  const std::vector<std::string> expected = SchemaOf(fresh.path() / "freelsd.db");
  REQUIRE(expected.size() > 50);
  CHECK(SchemaOf(folder.path() / "freelsd.db") == expected);
  CHECK(SchemaOf(folder.path() / "recall.db") == expected);
}

TEST_CASE("migrations: samples of 0.1.0 keep their order, and what arrives now is later") {
  const TemporaryFolder folder;
  WriteVersion3(folder.path());
  Execute(folder.path() / "freelsd.db",
          "INSERT INTO telemetry VALUES ('f', 0, 9223372036854775807, 48.0, 8.0, 400.0, 0.0), "
          "('f', 0, 5, 46.0, 8.0, 400.0, 0.0)");
  Storage storage(folder.path());
  const auto latitudes = [&storage] {
    std::vector<double> found;
    for (const auto& row : storage.telemetry.Recent("f", TelemetryKind::kPosition, 9)) {
      found.push_back(row.values[0]);
    }
    return found;
  };
  CHECK(latitudes() == std::vector<double>{46.0, 47.0, 48.0});
  CHECK(storage.telemetry.Recent("f", TelemetryKind::kPosition, 1).back().arrived_at_us <= 0);
  storage.telemetry.Put("f", {{TelemetryKind::kPosition, 1, {45.0, 8.0, 400.0, 0.0}}});
  CHECK(latitudes() == std::vector<double>{46.0, 47.0, 48.0, 45.0});
}

TEST_CASE("migrations: a database of version 6 gets obstacles in both files and keeps its sites") {
  const TemporaryFolder folder;
  { Storage(folder.path()).sites.Put(SomeSite("f-r3", 50.0, 8.0), "map"); }
  for (const char* const name : {"freelsd.db", "recall.db"}) {
    const std::string sql =
        "ALTER TABLE sites DROP COLUMN seen_until_us; "
        "DROP TABLE feed; DROP TABLE follow_state; DROP VIEW told_changes; DROP TABLE changes; "
        "DROP TRIGGER site_is_stored; DROP TRIGGER site_is_updated; "
        "DROP TRIGGER site_stands_otherwise; DROP TRIGGER site_is_removed; "
        "DROP INDEX site_numbers_by_aircraft; "
        "DROP TABLE obstacles; DROP TABLE photo_tiles; DROP TABLE map_tiles; DROP TABLE maps; "
        "PRAGMA user_version = 6; PRAGMA application_id = " +
        std::to_string(ApplicationId(6));
    Execute(folder.path() / name, sql.c_str());
  }
  {
    Storage storage(folder.path());
    CHECK(storage.Notices().empty());
    CHECK(storage.sites.ReadMap("f-r3") == "map");
    storage.obstacles.Put({{"wire", "{}", {}, std::nullopt, 5}}, 5);
  }
  std::filesystem::remove(folder.path() / "freelsd.db");
  CHECK(Storage(folder.path()).obstacles.Find("wire"));
}

TEST_CASE("migrations: a time that was unknown, and stored as the evaluation's, is unknown again") {
  const TemporaryFolder folder;
  const auto put = [&folder](const std::string& flight_id, int64_t photographed_at_us) {
    Storage storage(folder.path());
    FlightMapRow map = SomeMap(flight_id + "/1", flight_id, {7.0, 49.0, 9.0, 51.0});
    map.updated_at_us = 1000;
    map.seen_at_us = photographed_at_us;
    storage.maps.Stage(map, {}, {});
    SiteRow site = SomeSite(flight_id + "-r1", 50.0, 8.0);
    site.map_id = map.id;
    site.is_checked = true;
    // Sites that were found on a map had the evaluation's time.
    site.updated_at_us = site.seen_at_us = 1001;
    storage.sites.PutEvaluation({{site}, {}, {map.id}, {}}, {});
  };
  put("dated", 500);
  put("undated", 1000);
  for (const char* const name : {"freelsd.db", "recall.db"}) {
    const std::string sql =
        "ALTER TABLE sites DROP COLUMN seen_until_us; ALTER TABLE maps DROP COLUMN seen_until_us; "
        "PRAGMA user_version = 10; PRAGMA application_id = " +
        std::to_string(ApplicationId(10));
    Execute(folder.path() / name, sql.c_str());
  }
  const Storage storage(folder.path());
  CHECK(storage.Notices().empty());
  const SiteRow dated = *storage.sites.Find("dated-r1"),
                undated = *storage.sites.Find("undated-r1");
  CHECK(dated.seen_at_us == 500);
  CHECK_FALSE(dated.seen_until_us);
  CHECK(undated.seen_at_us == 0);
  CHECK(undated.seen_until_us == 1001);
  CHECK(storage.maps.Find("dated/1")->seen_at_us == 500);
  CHECK(storage.maps.Find("undated/1")->seen_at_us == 0);
  CHECK(storage.maps.Find("undated/1")->seen_until_us == 1000);
  CHECK_FALSE(dated.is_checked);
}

}  // namespace
}  // namespace freelsd
