// A folder with two sites, and ways to spoil its files.
#pragma once

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/storage/rows.h"

namespace freelsd {

// Overwrites a part of the file with bytes that are not SQLite's.
inline void Spoil(const std::filesystem::path& file, uint64_t begin, uint64_t size) {
  std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
  stream.seekp(static_cast<std::streamoff>(begin));
  stream << std::string(size, '\xa5');
}

// Two sites, the first with a map, and a flight.
inline void StoreTwoSites(const std::filesystem::path& folder) {
  Storage storage(folder);
  storage.InsertFlight(SomeFlight("f"));
  SiteRow site = SomeSite("f-r1", 50.0, 8.0);
  site.recall = RecallData{true, 300.0, "amsl", 0.7, "{}"};
  storage.PutSite(site, "map");
  storage.PutSite(SomeSite("f-r2", 50.1, 8.0), "");
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
  return storage.ListSites(std::nullopt, std::nullopt).size() == 2 &&
         storage.ReadSiteMap("f-r1") == "map" &&
         storage.ListRecallable({7.0, 49.0, 9.0, 51.0}).size() == 1;
}

}  // namespace freelsd
