// Damage of either file, of every kind that was met: the folder opens, and sites are recalled.
#include "tests/storage/sqlite/damage.h"

#include <filesystem>
#include <string>

#include <doctest/doctest.h>

#include "storage/sqlite/schema.h"
#include "tests/storage/rows.h"

namespace freelsd {
namespace {

constexpr std::streamoff kHeaderBytes = 100;    // of SQLite's file
constexpr std::streamoff kPlaceOfVersion = 63;  // user_version's last byte

TEST_CASE("damage: any byte of the head may be another, and both sites are recalled") {
  const TemporaryFolder whole;
  const TemporaryFolder folder;
  StoreTwoSites(folder.path());
  const auto copy_files = [](const std::filesystem::path& from, const std::filesystem::path& to) {
    for (const char* const name : {"freelsd.db", "recall.db"}) {
      constexpr auto kOver = std::filesystem::copy_options::overwrite_existing;
      std::filesystem::copy_file(from / name, to / name, kOver);
    }
  };
  copy_files(folder.path(), whole.path());
  for (std::streamoff at = 0; at < kHeaderBytes; ++at) {
    CAPTURE(at);
    copy_files(whole.path(), folder.path());
    WriteAt(folder.path() / "freelsd.db", at, at % 2 == 0 ? "\x05" : "\xc3");
    CHECK(HasBoth(Storage(folder.path())));
  }
}

TEST_CASE("damage: another number beside a copy of this one is none") {
  const std::string next(1, static_cast<char>(kSchemaNumber + 1));
  for (const std::string& version : {next, std::string("\xff")}) {
    const TemporaryFolder folder;
    StoreTwoSites(folder.path());
    WriteAt(folder.path() / "freelsd.db", kPlaceOfVersion, version);
    const Storage storage(folder.path());
    CHECK(HasBoth(storage));
    CHECK(storage.Notices().size() == 1);
  }
}

TEST_CASE("damage: a table that reads as empty takes nothing from the copy") {
  const TemporaryFolder folder;
  StoreTwoSites(folder.path());
  // As where its first page came to lie where another table's was.
  Execute(folder.path() / "freelsd.db",
          "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET rootpage = (SELECT rootpage FROM "
          "sqlite_schema WHERE name = 'jobs') WHERE name = 'sites'");
  const Storage storage(folder.path());
  CHECK(HasBoth(storage));
  CHECK(storage.Notices().size() == 1);
}

TEST_CASE("damage: sites whose places are lost are recalled all the same, and it is told") {
  const TemporaryFolder folder;
  StoreTwoSites(folder.path());
  Execute(folder.path() / "freelsd.db", "DELETE FROM site_boxes");
  const Storage storage(folder.path());
  CHECK(HasBoth(storage));
  REQUIRE(AwaitNotices(storage).size() == 1);
  CHECK(storage.Notices()[0].find("the database is damaged") == 0);
}

TEST_CASE("damage: a site whose row is lost is found in the copy") {
  const TemporaryFolder folder;
  StoreTwoSites(folder.path());
  const Storage storage(folder.path());
  Execute(folder.path() / "freelsd.db", "DELETE FROM sites WHERE id = 'f-r1'");
  CHECK(storage.sites.Find("f-r1"));
}

TEST_CASE("damage: of what a kill left between two commits nothing is made") {
  const TemporaryFolder folder;
  StoreTwoSites(folder.path());
  // The database forgot a site, its copy did not come to it.
  Execute(folder.path() / "freelsd.db",
          "PRAGMA foreign_keys = ON; DELETE FROM site_boxes WHERE number = (SELECT number FROM "
          "site_numbers WHERE site_id = 'f-r1'); DELETE FROM sites WHERE id = 'f-r1'");
  const Storage storage(folder.path());
  CHECK(storage.Notices().empty());
  CHECK(storage.sites.List(std::nullopt, std::nullopt).size() == 1);
  CHECK(storage.sites.ListRecallable({7.0, 49.0, 9.0, 51.0}).empty());
}

TEST_CASE("damage: a spoilt copy is made anew from the database, flights and all") {
  for (const uint64_t begin : {0, 4096, 8192}) {
    CAPTURE(begin);
    const TemporaryFolder folder;
    StoreTwoSites(folder.path());
    const std::filesystem::path copy = folder.path() / "recall.db";
    Spoil(copy, begin, std::filesystem::file_size(copy) - begin);
    {
      const Storage storage(folder.path());
      CHECK(HasBoth(storage));
      CHECK(storage.flights.Find("f"));
    }
    Spoil(folder.path() / "freelsd.db", 0, 4096);
    CHECK(HasBoth(Storage(folder.path())));
  }
}

TEST_CASE("damage: lost places in the copy are told, and the next start makes it anew") {
  const TemporaryFolder folder;
  StoreTwoSites(folder.path());
  Execute(folder.path() / "recall.db", "DELETE FROM site_boxes");
  {
    const Storage storage(folder.path());
    REQUIRE(AwaitNotices(storage).size() == 1);
    CHECK(storage.Notices()[0].find("the second copy") == 0);
    CHECK(HasBoth(storage));
    CHECK(storage.flights.Find("f"));
  }
  const Storage storage(folder.path());
  REQUIRE(storage.Notices().size() == 1);
  CHECK(storage.Notices()[0].find("made anew from the database") != std::string::npos);
  CHECK(HasBoth(storage));
}

void SpoilBoth(const std::filesystem::path& folder, const std::string& kind) {
  for (const char* const name : {"freelsd.db", "recall.db"}) {
    const std::filesystem::path file = folder / name;
    if (kind == "head") Spoil(file, 0, 4096);
    if (kind == "pages") Spoil(file, 4096, std::filesystem::file_size(file) - 4096);
    if (kind == "cut") std::filesystem::resize_file(file, 0);
    if (kind == "gone") std::filesystem::remove(file);
    if (kind == "overwritten") std::ofstream(file) << std::string(20'000, 'x');
  }
}

TEST_CASE("damage: both damaged: both are set aside, and a notice says that nothing was restored") {
  for (const std::string kind : {"head", "pages", "cut", "gone", "overwritten"}) {
    CAPTURE(kind);
    const TemporaryFolder folder;
    StoreTwoSites(folder.path());
    SpoilBoth(folder.path(), kind);
    {
      Storage storage(folder.path());
      CHECK(storage.sites.List(std::nullopt, std::nullopt).empty());
      REQUIRE(storage.Notices().size() == 1);
      CHECK(storage.Notices()[0].find("nothing could be restored") != std::string::npos);
      CHECK(storage.Notices()[0].find("were restored") == std::string::npos);
      storage.flights.Insert(SomeFlight("g"));
      CHECK(storage.flights.Find("g"));
    }
    int num_kept = 0;
    for (const auto& file : std::filesystem::recursive_directory_iterator(folder.path())) {
      const bool is_aside = file.path().string().find("/damaged-") != std::string::npos;
      num_kept += is_aside && file.path().extension() == ".db";
    }
    CHECK(num_kept == (kind == "gone" ? 0 : 2));
    // It is told until it is acknowledged.
    const Storage again(folder.path());
    REQUIRE(again.Notices().size() == 1);
    CHECK(again.AcknowledgeNotice(again.ListNotices()[0].id));
    CHECK(again.Notices().empty());
    CHECK(again.ListNotices().size() == 1);
  }
}

TEST_CASE("damage: the notice says how much was restored, and how old it is") {
  const TemporaryFolder folder;
  StoreTwoSites(folder.path());
  Spoil(folder.path() / "freelsd.db", 0, 4096);
  const Storage storage(folder.path());
  REQUIRE(storage.Notices().size() == 1);
  const std::string notice = storage.Notices()[0];
  CHECK(notice.find("2 sites, 1 map and 0 obstacles were restored") != std::string::npos);
  CHECK(notice.find("written last at 20") != std::string::npos);
}

TEST_CASE("damage: of the copy alone: a notice and a line of the log") {
  const TemporaryFolder folder;
  StoreTwoSites(folder.path());
  const std::filesystem::path copy = folder.path() / "recall.db";
  // All but the first page: which pages a start reads depends on the schema.
  Spoil(copy, 4096, std::filesystem::file_size(copy) - 4096);
  std::vector<std::string> logged;
  StorageOptions options;
  options.folder = folder.path();
  options.log_notice = [&logged](const std::string& text) { logged.push_back(text); };
  const Storage storage(options);
  REQUIRE(storage.Notices().size() == 1);
  CHECK(logged == storage.Notices());
  CHECK(HasBoth(storage));
}

TEST_CASE("damage: a restart amid the restoring takes nothing from the copy") {
  const TemporaryFolder folder;
  const TemporaryFolder fresh;
  StoreTwoSites(folder.path());
  { const Storage storage(fresh.path()); }
  // The new database has a schema, but nothing from the copy yet.
  std::filesystem::copy_file(fresh.path() / "freelsd.db",
                             folder.path() / "freelsd.db",
                             std::filesystem::copy_options::overwrite_existing);
  CHECK(HasBoth(Storage(folder.path())));
}

TEST_CASE("damage: a database that is damaged, cut or gone is set aside, and sites stay") {
  for (const std::string kind : {"spoilt", "cut", "gone", "format", "version"}) {
    INFO(kind);
    const TemporaryFolder folder;
    StoreTwoSites(folder.path());
    const std::filesystem::path file = folder.path() / "freelsd.db";
    if (kind == "spoilt") Spoil(file, 0, 4096);
    // Numbers in the head that nothing ever writes: of the file's format, and of our schema.
    if (kind == "format") WriteAt(file, 44, "\x7f\x7f\x7f\x7f");
    if (kind == "version") WriteAt(file, 60, "\x7f\x7f\x7f\x7f");
    if (kind == "cut") std::filesystem::resize_file(file, 0);
    if (kind == "gone") std::filesystem::remove(file);
    if (kind == "overwritten") std::ofstream(file) << std::string(20'000, 'x');
    Storage storage(folder.path());
    CHECK(HasBoth(storage));
    REQUIRE(storage.Notices().size() == 1);
    CHECK(storage.Notices()[0].find("damaged-1") != std::string::npos);
    CHECK(std::filesystem::exists(folder.path() / "damaged-1/images"));
    // It goes on with a database that is whole.
    storage.flights.Insert(SomeFlight("g"));
    CHECK(storage.flights.List().size() == 1);
  }
}

TEST_CASE("damage: damage that shows in use leaves sites readable and is set aside at the start") {
  const TemporaryFolder folder;
  StoreTwoSites(folder.path());
  // All pages but the schema's own.
  const std::filesystem::path file = folder.path() / "freelsd.db";
  Spoil(file, 4096, std::filesystem::file_size(file) - 4096);
  {
    // Noticed by the second try at the latest.
    const Storage storage(folder.path());
    CHECK(HasBoth(storage));
  }
  const TemporaryFolder other;
  StoreTwoSites(other.path());
  {
    Storage storage(other.path());
    storage.MarkDamaged("a test");
    CHECK(HasBoth(storage));
    CHECK(storage.WhyNotWritable());
    CHECK_THROWS_AS(storage.flights.Insert(SomeFlight("g")), StorageError);
    CHECK(storage.Notices().size() == 1);
  }
  const Storage storage(other.path());
  CHECK(HasBoth(storage));
  CHECK_FALSE(storage.flights.Find("f"));
  CHECK(std::filesystem::exists(other.path() / "damaged-1/freelsd.db"));
}

TEST_CASE("damage: a row that is not what was written is taken from the second copy") {
  const TemporaryFolder folder;
  StoreTwoSites(folder.path());
  Execute(folder.path() / "freelsd.db",
          "UPDATE site_numbers SET altitude_m = 0 WHERE is_recallable = 1");
  const Storage storage(folder.path());
  const auto rows = storage.sites.ListRecallable({7.0, 49.0, 9.0, 51.0});
  REQUIRE(rows.size() == 1);
  CHECK(rows[0]->data.altitude_m == 300.0);
  CHECK(AwaitNotices(storage).size() == 1);
}

TEST_CASE("damage: a copy that is damaged or gone is made anew") {
  const TemporaryFolder folder;
  StoreTwoSites(folder.path());
  const std::filesystem::path copy = folder.path() / "recall.db";
  Spoil(copy, 0, 4096);
  {
    const Storage storage(folder.path());
    REQUIRE(storage.Notices().size() == 1);
    CHECK(storage.Notices()[0].find("made anew from the database") != std::string::npos);
  }
  std::filesystem::remove(copy);
  CHECK(Storage(folder.path()).Notices().size() == 2);
  Spoil(folder.path() / "freelsd.db", 0, 4096);
  CHECK(HasBoth(Storage(folder.path())));
}

}  // namespace
}  // namespace freelsd
