// Map tiles of others: good files, and bad ones that must only be refused.
#include "storage/mbtiles.h"

#include <fstream>
#include <iterator>
#include <random>

#include <doctest/doctest.h>

#include "storage/storage_error.h"
#include "tests/storage/mbtiles_file.h"
#include "tests/storage/rows.h"

namespace freelsd {
namespace {

std::string BytesOf(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(stream), {});
}

size_t NumFiles(const std::filesystem::path& folder) {
  return static_cast<size_t>(std::distance(std::filesystem::directory_iterator(folder),
                                           std::filesystem::directory_iterator()));
}

void WriteGoodFile(const std::filesystem::path& path) {
  MbTilesFile file(path);
  file.SetMetadata("name", "hills");
  file.SetMetadata("format", "png");
  file.SetMetadata("minzoom", "0");
  file.SetMetadata("maxzoom", "2");
  file.SetMetadata("bounds", "7.5,46,9,47.25");
  file.SetMetadata("attribution", "the survey");
  file.AddTile(0, 0, 0, kPngTile);
  file.AddTile(2, 1, 3, kJpegTile);
  file.AddTile(2, 3, 0, kWebpTile);
}

TEST_CASE(
    "mbtiles: tiles are found with rows from the north, with their kind by their first bytes") {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a map 100%?#.mbtiles";
  WriteGoodFile(path);
  const MbTiles tiles(path);
  CHECK(tiles.info().name == "hills");
  CHECK(tiles.info().attribution == "the survey");
  CHECK(tiles.info().min_zoom == 0);
  CHECK(tiles.info().max_zoom == 2);
  CHECK(tiles.info().bounds_deg == std::array<double, 4>{7.5, 46.0, 9.0, 47.25});
  CHECK(tiles.Find(0, 0, 0)->bytes == kPngTile);
  CHECK(tiles.Find(0, 0, 0)->media_type == "image/png");
  CHECK(tiles.Find(2, 1, 0)->bytes == kJpegTile);
  CHECK(tiles.Find(2, 1, 0)->media_type == "image/jpeg");
  CHECK(tiles.Find(2, 3, 3)->media_type == "image/webp");
}

TEST_CASE("mbtiles: places without a tile and places outside the world have none") {
  const TemporaryFolder folder;
  WriteGoodFile(folder.path() / "map");
  const MbTiles tiles(folder.path() / "map");
  CHECK_FALSE(tiles.Find(2, 1, 3));
  CHECK_FALSE(tiles.Find(-1, 0, 0));
  CHECK_FALSE(tiles.Find(31, 0, 0));
  CHECK_FALSE(tiles.Find(2, 4, 0));
  CHECK_FALSE(tiles.Find(2, 0, -1));
  CHECK_FALSE(tiles.Find(2, int64_t{1} << 62, int64_t{1} << 62));
}

TEST_CASE("mbtiles: a file is only read: no byte changes, no file appears, not even of a WAL") {
  const TemporaryFolder folder;
  const auto path = folder.path() / "map";
  WriteGoodFile(path);
  MbTilesFile(path, "PRAGMA journal_mode = WAL").Run("INSERT INTO metadata VALUES ('a', 'b')");
  const std::string before = BytesOf(path);
  REQUIRE(NumFiles(folder.path()) == 1);
  std::filesystem::permissions(path, std::filesystem::perms::owner_read);
  {
    const MbTiles tiles(path);
    CHECK(tiles.Find(0, 0, 0));
    CHECK(NumFiles(folder.path()) == 1);
  }
  CHECK(NumFiles(folder.path()) == 1);
  CHECK(BytesOf(path) == before);
}

TEST_CASE(
    "mbtiles: zoom levels come from the tiles if the metadata has none, bad bounds are left out") {
  const TemporaryFolder folder;
  {
    MbTilesFile file(folder.path() / "map");
    file.SetMetadata("bounds", "9,46,nan,47");
    file.AddTile(3, 0, 0, kPngTile);
    file.AddTile(7, 0, 0, kPngTile);
  }
  const MbTiles tiles(folder.path() / "map");
  CHECK(tiles.info().min_zoom == 3);
  CHECK(tiles.info().max_zoom == 7);
  CHECK_FALSE(tiles.info().bounds_deg);
}

TEST_CASE("mbtiles: zoom levels of the metadata that are none are read from the tiles") {
  const TemporaryFolder folder;
  int number = 0;
  for (const auto& [least, most] : {std::pair{"", ""}, {"far", "1e9"}, {"9", "2"}, {" ", "-1"}}) {
    const auto path = folder.path() / ("map" + std::to_string(++number));
    {
      MbTilesFile file(path);
      file.SetMetadata("minzoom", least);
      file.SetMetadata("maxzoom", most);
      file.AddTile(3, 0, 0, kPngTile);
      file.AddTile(7, 0, 0, kPngTile);
    }
    const MbTiles tiles(path);
    CHECK(tiles.info().min_zoom == 3);
    CHECK(tiles.info().max_zoom == 7);
  }
}

TEST_CASE("mbtiles: what is still in a write-ahead log is not read past, which is said") {
  const TemporaryFolder folder;
  const auto path = folder.path() / "map";
  WriteGoodFile(path);
  std::ofstream(folder.path() / "map-wal") << "frames";
  CHECK_THROWS_WITH_AS(MbTiles{path}, doctest::Contains("write-ahead log"), StorageError);
  std::filesystem::resize_file(folder.path() / "map-wal", 0);
  CHECK_NOTHROW(MbTiles{path});
}

TEST_CASE("mbtiles: tiles may be a view, as many programs write them") {
  const TemporaryFolder folder;
  {
    MbTilesFile file(folder.path() / "map",
                     "CREATE TABLE metadata (name TEXT, value TEXT);"
                     "CREATE TABLE map (zoom_level, tile_column, tile_row, tile_id);"
                     "CREATE TABLE images (tile_data, tile_id);"
                     "CREATE VIEW tiles AS SELECT zoom_level, tile_column, tile_row, tile_data "
                     "FROM map JOIN images ON images.tile_id = map.tile_id;"
                     "INSERT INTO map VALUES (1, 0, 1, 'sea'), (1, 1, 1, 'sea');");
    file.Run("INSERT INTO images VALUES (X'FFD8FFE0', 'sea')");
  }
  const MbTiles tiles(folder.path() / "map");
  CHECK(tiles.Find(1, 0, 0)->media_type == "image/jpeg");
  CHECK(tiles.Find(1, 1, 0));
}

void WriteWith(const std::filesystem::path& path, const char* sql) {
  const MbTilesFile file(path, sql);
}

void CheckRefused(const std::filesystem::path& path, const char* why) {
  CHECK_THROWS_WITH_AS(MbTiles{path}, doctest::Contains(why), StorageError);
}

TEST_CASE("mbtiles: what is no MBTiles file with pictures is refused with the reason") {
  const TemporaryFolder folder;
  const auto path = folder.path() / "map";
  CheckRefused(path, "no such file");
  CheckRefused(folder.path(), "no such file");
  std::ofstream(path) << "this is a text, and it is long enough to be looked at by SQLite ........";
  CheckRefused(path, "not a database");
  std::ofstream(path, std::ios::trunc).flush();
  CheckRefused(path, "no table metadata");
  WriteWith(path, "CREATE TABLE metadata (name, value)");
  CheckRefused(path, "no table tiles");
  WriteWith(path, "CREATE TABLE tiles (zoom_level, tile_column, tile_row, tile_data)");
  CheckRefused(path, "has no tiles");
  MbTilesFile(path, "").AddTile(0, 0, 0, "\x1f\x8b\x08 gzip");
  CheckRefused(path, "vector tile");
  WriteWith(path, "INSERT INTO metadata VALUES ('format', 'pbf')");
  CheckRefused(path, "vector tiles (pbf)");
  MbTilesFile(path, "DELETE FROM metadata; DELETE FROM tiles").AddTile(0, 0, 0, "<html>");
  CheckRefused(path, "not a picture");
  MbTilesFile(path, "DELETE FROM tiles").AddTile(-5, 0, 0, kPngTile);
  CheckRefused(path, "zoom level");
  WriteWith(path, "INSERT INTO metadata VALUES ('minzoom', 'far')");
  CheckRefused(path, "zoom level");
  std::filesystem::remove(path);
  WriteWith(path, "CREATE TABLE metadata (a, b); CREATE TABLE tiles (a, b)");
  CheckRefused(path, "no such column");
}

TEST_CASE("mbtiles: one bad tile is refused, and the others are still found") {
  const TemporaryFolder folder;
  const auto path = folder.path() / "map";
  {
    MbTilesFile file(path);
    file.AddTile(1, 0, 0, kPngTile);
    file.AddTile(1, 1, 0, "");
    file.AddTile(1, 0, 1, kPngTile + std::string(2000, 'x'));
    // More than SQLite itself may read here.
    file.Run("INSERT INTO tiles VALUES (1, 1, 1, zeroblob(5000000))");
    file.Run("INSERT INTO tiles VALUES (2, 0, 0, 42)");
  }
  MbTilesOptions options;
  options.max_tile_bytes = 1000;
  const MbTiles tiles(path, options);
  CHECK_THROWS_WITH_AS(tiles.Find(1, 1, 1), doctest::Contains("not a picture"), StorageError);
  CHECK_THROWS_WITH_AS(tiles.Find(1, 0, 0), doctest::Contains("1000 bytes"), StorageError);
  CHECK_THROWS_WITH_AS(tiles.Find(1, 1, 0), doctest::Contains("too big"), StorageError);
  CHECK_THROWS_AS(tiles.Find(2, 0, 3), StorageError);
  CHECK(tiles.Find(1, 0, 1)->bytes == kPngTile);
}

TEST_CASE("mbtiles: a view that never ends, calls programs or reads other files does no harm") {
  const TemporaryFolder folder;
  const auto path = folder.path() / "map";
  WriteWith(
      path,
      "CREATE TABLE metadata (name, value);"
      "CREATE VIEW tiles AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) "
      "SELECT i AS zoom_level, i AS tile_column, i AS tile_row, X'FFD8FF' AS tile_data FROM n");
  CheckRefused(path, "not authorized");
  // A product of tables takes longer than any clock.
  WriteWith(path,
            "DROP VIEW tiles; CREATE TABLE a (i); INSERT INTO a VALUES (1), (2), (3), (4), (5);"
            "INSERT INTO a SELECT b.i FROM a, a AS b, a AS c, a AS d;"
            "CREATE TABLE one (zoom_level, tile_column, tile_row, tile_data);"
            "INSERT INTO one VALUES (0, 0, 0, X'FFD8FF');"
            "CREATE VIEW tiles AS SELECT * FROM one UNION ALL SELECT 1, b.i, c.i + d.i, X'FFD8FF' "
            "FROM a, a AS b, a AS c, a AS d WHERE a.i + b.i + c.i + d.i > 100;"
            "INSERT INTO metadata VALUES ('minzoom', '0'), ('maxzoom', '1');");
  MbTilesOptions options;
  options.max_search = std::chrono::milliseconds(50);
  const MbTiles tiles(path, options);
  const auto begin = std::chrono::steady_clock::now();
  CHECK_THROWS_WITH_AS(tiles.Find(1, 0, 0), doctest::Contains("interrupted"), StorageError);
  CHECK(std::chrono::steady_clock::now() - begin < std::chrono::seconds(2));
}

TEST_CASE("mbtiles: bits turned and ends cut off anywhere never end the program") {
  const TemporaryFolder folder;
  const auto path = folder.path() / "map";
  {
    MbTilesFile file(path);
    for (int i = 0; i < 200; ++i) file.AddTile(8, i, i, kPngTile + std::string(300, 'x'));
  }
  const std::string good = BytesOf(path);
  std::mt19937 random(7);
  int num_refused = 0;
  for (int round = 0; round < 300; ++round) {
    std::string bytes = good;
    for (int i = 0; i < 20; ++i)
      bytes[random() % bytes.size()] ^= static_cast<char>(1U << random() % 8);
    if (round % 3 == 0) bytes.resize(random() % bytes.size());
    std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
    try {
      const MbTiles tiles(path);
      for (int i = 0; i < 200; ++i) tiles.Find(8, i, 255 - i);
    } catch (const StorageError&) {
      ++num_refused;
    }
  }
  CHECK(num_refused > 100);
}

}  // namespace
}  // namespace freelsd
