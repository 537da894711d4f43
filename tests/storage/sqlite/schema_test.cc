#include "storage/sqlite/schema.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "storage/storage.h"
#include "tests/storage/rows.h"
#include "tests/storage/sqlite/damage.h"

namespace freelsd {
namespace {

constexpr int64_t kOlder = kSchemaNumber - 1, kNewer = kSchemaNumber + 1;

// Of every file below the folder.
std::map<std::string, std::string> BytesOf(const std::filesystem::path& folder) {
  std::map<std::string, std::string> bytes;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream stream(entry.path(), std::ios::binary);
    bytes[entry.path()] = std::string(std::istreambuf_iterator<char>(stream), {});
  }
  return bytes;
}

void SetNumber(const std::filesystem::path& file, int64_t number, int64_t application_id) {
  const std::string sql = "PRAGMA user_version = " + std::to_string(number) +
                          "; PRAGMA application_id = " + std::to_string(application_id);
  Execute(file, sql.c_str());
}

void CheckRefused(const std::filesystem::path& folder, int64_t number) {
  const std::map<std::string, std::string> before = BytesOf(folder);
  try {
    const Storage storage(folder);
    FAIL("it was opened");
  } catch (const StorageError& error) {
    const std::string text = error.what();
    CHECK(error.fault == StorageFault::kOtherSchema);
    CHECK(text.find("schema number " + std::to_string(number)) != std::string::npos);
    CHECK(text.find("number " + std::to_string(kSchemaNumber) + " only") != std::string::npos);
    CHECK(text.find("POST the photographs of each flight again") != std::string::npos);
  }
  CHECK((BytesOf(folder) == before));
}

TEST_CASE("schema: a folder of another number is refused with a sentence, and left as it is") {
  // Of both files, or of the one that the other program came to before it was killed.
  const std::vector<std::vector<std::string>> cases{
      {"freelsd.db", "recall.db"}, {"freelsd.db"}, {"recall.db"}};
  for (const int64_t number : {kOlder, kNewer}) {
    for (const std::vector<std::string>& files : cases) {
      CAPTURE(number);
      CAPTURE(files.size());
      CAPTURE(files[0]);
      const TemporaryFolder folder;
      {
        Storage storage(folder.path());
        storage.flights.Insert(SomeFlight("f"));
        PutSite(storage, SomeSite("f-r3", 50.0, 8.0));
      }
      std::ofstream(folder.path() / "damaged") << "so the other program said";
      for (const std::string& name : files) {
        SetNumber(folder.path() / name, number, ApplicationId(number));
      }
      CheckRefused(folder.path(), number);
    }
  }
}

TEST_CASE("schema: beside a database that is spoilt or gone, a copy of another number is left") {
  for (const bool is_gone : {false, true}) {
    for (const int64_t number : {kOlder, kNewer}) {
      const TemporaryFolder folder;
      {
        Storage storage(folder.path());
        PutSite(storage, SomeSite("f-r3", 50.0, 8.0));
      }
      SetNumber(folder.path() / "recall.db", number, ApplicationId(number));
      std::filesystem::resize_file(folder.path() / "freelsd.db", 50);
      if (is_gone) std::filesystem::remove(folder.path() / "freelsd.db");
      CheckRefused(folder.path(), number);
    }
  }
}

TEST_CASE("schema: the first programs, which set no application_id, are refused") {
  const TemporaryFolder folder;
  { const Storage storage(folder.path()); }
  for (const char* const name : {"freelsd.db", "recall.db"}) {
    SetNumber(folder.path() / name, 3, 0);
  }
  CheckRefused(folder.path(), 3);
}

TEST_CASE("schema: two files of another number are refused, whatever they say besides") {
  for (const int64_t number : {kOlder, kNewer}) {
    const TemporaryFolder folder;
    { const Storage storage(folder.path()); }
    for (const char* const name : {"freelsd.db", "recall.db"}) {
      SetNumber(folder.path() / name, number, ApplicationId(kSchemaNumber));
    }
    CheckRefused(folder.path(), number);
  }
}

TEST_CASE("schema: a folder of another number stays as it is also after a kill") {
  // The number is in the write-ahead log, which SQLite would write into the file.
  const TemporaryFolder killed, folder;
  std::filesystem::create_directories(killed.path());
  sqlite3* database = nullptr;
  REQUIRE(sqlite3_open((killed.path() / "freelsd.db").c_str(), &database) == SQLITE_OK);
  const std::string sql =
      "PRAGMA journal_mode = WAL; CREATE TABLE sites (id TEXT); "
      "PRAGMA user_version = " +
      std::to_string(kOlder) +
      "; PRAGMA application_id = " + std::to_string(ApplicationId(kOlder)) +
      "; INSERT INTO sites VALUES ('f-r1')";
  REQUIRE(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK);
  // A folder that was in use: with its lock file.
  { const Storage storage(folder.path()); }
  for (const char* const name : {"freelsd.db", "recall.db"}) {
    std::filesystem::remove(folder.path() / name);
  }
  for (const char* const name : {"freelsd.db", "freelsd.db-wal"}) {
    std::filesystem::copy_file(killed.path() / name, folder.path() / name);
  }
  sqlite3_close(database);
  REQUIRE(std::filesystem::file_size(folder.path() / "freelsd.db-wal") > 0);
  CheckRefused(folder.path(), kOlder);
}

}  // namespace
}  // namespace freelsd
