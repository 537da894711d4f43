// A folder with two sites, and ways to spoil its files.
#pragma once

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include <doctest/doctest.h>
#include <sqlite3.h>

#include "storage/storage.h"
#include "tests/storage/rows.h"

namespace freelsd {

// On a closed database, as another program would.
inline void Execute(const std::filesystem::path& file, const char* sql) {
  sqlite3* database = nullptr;
  REQUIRE(sqlite3_open(file.c_str(), &database) == SQLITE_OK);
  REQUIRE(sqlite3_exec(database, sql, nullptr, nullptr, nullptr) == SQLITE_OK);
  sqlite3_close(database);
}

// Overwrites a part of the file with bytes that are not SQLite's.
inline void Spoil(const std::filesystem::path& file, uint64_t begin, uint64_t size) {
  std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
  stream.seekp(static_cast<std::streamoff>(begin));
  stream << std::string(size, '\xa5');
}

// Two sites, the first on a map, and a flight.
inline void StoreTwoSites(const std::filesystem::path& folder) {
  Storage storage(folder);
  storage.flights.Insert(SomeFlight("f"));
  SiteRow site = SomeSite("f-r1", 50.0, 8.0);
  site.recall = RecallData{true, 300.0, "amsl", 0.7, "{}"};
  site.map_id = "f/1";
  storage.maps.Stage(SomeMap("f/1", "f", {7.9, 49.9, 8.1, 50.1}), {{{0, 0, 0}, "map"}}, {});
  storage.sites.PutEvaluation({{site}, {}, {"f/1"}, {}}, {});
  PutSite(storage, SomeSite("f-r2", 50.1, 8.0));
}

inline void WriteAt(const std::filesystem::path& file,
                    std::streamoff place,
                    const std::string& bytes) {
  std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
  stream.seekp(place);
  stream << bytes;
}

// The check of whole files runs beside everything else.
inline std::vector<std::string> AwaitNotices(const Storage& storage) {
  for (int i = 0; i < 500 && storage.Notices().empty(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return storage.Notices();
}

inline bool HasBoth(const Storage& storage) {
  return storage.sites.List(std::nullopt, std::nullopt).size() == 2 &&
         storage.maps.ReadTile("f/1", {0, 0, 0}) == "map" &&
         storage.sites.ListRecallable({7.0, 49.0, 9.0, 51.0}).size() == 1;
}

}  // namespace freelsd
