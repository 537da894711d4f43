// Writes MBTiles files, good and bad ones.
#pragma once

#include <filesystem>
#include <string>

#include <doctest/doctest.h>
#include <sqlite3.h>

namespace freelsd {

// The beginnings of pictures are enough: nobody decodes them.
inline const std::string kPngTile = std::string("\x89PNG\r\n\x1a\n") + "a png";
inline const std::string kJpegTile = "\xff\xd8\xff\xe0 a jpeg";
inline const std::string kWebpTile = std::string("RIFF\x10\0\0\0WEBP", 12) + " a webp";

constexpr char kMbTilesSchema[] =
    "CREATE TABLE metadata (name TEXT, value TEXT);"
    "CREATE TABLE tiles (zoom_level INTEGER, tile_column INTEGER, tile_row INTEGER, tile_data "
    "BLOB);"
    "CREATE UNIQUE INDEX tile_index ON tiles (zoom_level, tile_column, tile_row);";

class MbTilesFile {
 public:
  explicit MbTilesFile(const std::filesystem::path& file, const char* schema = kMbTilesSchema) {
    REQUIRE(sqlite3_open(file.c_str(), &database_) == SQLITE_OK);
    Run(schema);
  }
  ~MbTilesFile() { sqlite3_close(database_); }
  MbTilesFile(const MbTilesFile&) = delete;
  MbTilesFile& operator=(const MbTilesFile&) = delete;

  void Run(const std::string& sql) {
    char* error = nullptr;
    const int result = sqlite3_exec(database_, sql.c_str(), nullptr, nullptr, &error);
    const std::string why = error == nullptr ? "" : error;
    INFO(why);
    REQUIRE(result == SQLITE_OK);
  }
  void SetMetadata(const std::string& name, const std::string& value) {
    char* const sql =
        sqlite3_mprintf("INSERT INTO metadata VALUES (%Q, %Q)", name.c_str(), value.c_str());
    Run(sql);
    sqlite3_free(sql);
  }
  // The row is counted from the south.
  void AddTile(int zoom, int column, int row, const std::string& bytes) {
    sqlite3_stmt* statement = nullptr;
    constexpr char kInsert[] = "INSERT INTO tiles VALUES (?1, ?2, ?3, ?4)";
    REQUIRE(sqlite3_prepare_v2(database_, kInsert, -1, &statement, nullptr) == SQLITE_OK);
    sqlite3_bind_int(statement, 1, zoom);
    sqlite3_bind_int(statement, 2, column);
    sqlite3_bind_int(statement, 3, row);
    sqlite3_bind_blob64(statement, 4, bytes.data(), bytes.size(), SQLITE_TRANSIENT);
    CHECK(sqlite3_step(statement) == SQLITE_DONE);
    sqlite3_finalize(statement);
  }

 private:
  sqlite3* database_ = nullptr;
};

}  // namespace freelsd
