// What recall needs of storage: sites that survive damage, and what else tells of them.
#include <filesystem>
#include <string>

#include <doctest/doctest.h>

#include "tests/storage/damage.h"
#include "tests/storage/rows.h"

namespace freelsd {
namespace {

TEST_CASE("storage: a database that is damaged, cut or gone is set aside, and sites stay") {
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
    Storage storage(folder.path());
    CHECK(HasBoth(storage));
    REQUIRE(storage.Notices().size() == 1);
    CHECK(storage.Notices()[0].find("damaged-1") != std::string::npos);
    CHECK(std::filesystem::exists(folder.path() / "damaged-1/images"));
    // It goes on with a database that is whole.
    storage.InsertFlight(SomeFlight("g"));
    CHECK(storage.ListFlights().size() == 1);
  }
}

TEST_CASE("storage: damage that shows in use leaves sites readable and is set aside at the start") {
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
    CHECK_THROWS_AS(storage.InsertFlight(SomeFlight("g")), StorageError);
    CHECK(storage.Notices().size() == 1);
  }
  const Storage storage(other.path());
  CHECK(HasBoth(storage));
  CHECK_FALSE(storage.FindFlight("f"));
  CHECK(std::filesystem::exists(other.path() / "damaged-1/freelsd.db"));
}

TEST_CASE("storage: a row that is not what was written is taken from the second copy") {
  const TemporaryFolder folder;
  StoreTwoSites(folder.path());
  Execute(folder.path() / "freelsd.db",
          "UPDATE site_numbers SET altitude_m = 0 WHERE is_recallable = 1");
  const Storage storage(folder.path());
  const auto rows = storage.ListRecallable({7.0, 49.0, 9.0, 51.0});
  REQUIRE(rows.size() == 1);
  CHECK(rows[0]->data.altitude_m == 300.0);
  CHECK(AwaitNotices(storage).size() == 1);
}

TEST_CASE("storage: a copy that is damaged or gone is made anew") {
  const TemporaryFolder folder;
  StoreTwoSites(folder.path());
  const std::filesystem::path copy = folder.path() / "recall.db";
  Spoil(copy, 0, 4096);
  {
    const Storage storage(folder.path());
    CHECK(storage.Notices().empty());
  }
  std::filesystem::remove(copy);
  { const Storage storage(folder.path()); }
  Spoil(folder.path() / "freelsd.db", 0, 4096);
  CHECK(HasBoth(Storage(folder.path())));
}

TEST_CASE("storage: a superseded site is not recalled, until what superseded it is gone") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
  SiteRow old_site = SomeSite("f-r1", 50.0, 8.0);
  old_site.recall = RecallData{true, 300.0, "amsl", 0.7, "{}"};
  storage.PutSite(old_site, "map");
  SiteRow new_site = old_site;
  new_site.id = std::string("g-r1");
  new_site.flight_id = std::string("g");
  storage.PutSite(new_site, "map", {"f-r1"});
  const BoundingBox box{7.0, 49.0, 9.0, 51.0};
  REQUIRE(storage.ListRecallable(box).size() == 1);
  CHECK(storage.ListRecallable(box)[0]->site_id == "g-r1");
  CHECK(storage.FindSite("f-r1")->superseded_by == "g-r1");
  // Its map still tells of terrain.
  CHECK(storage.ListMaps(box).size() == 2);
  CHECK(storage.DeleteSite("g-r1"));
  REQUIRE(storage.ListRecallable(box).size() == 1);
  CHECK(storage.ListRecallable(box)[0]->site_id == "f-r1");
}

TEST_CASE("storage: what bounds the reach of sites follows them") {
  const TemporaryFolder folder;
  StoreTwoSites(folder.path());
  Storage storage(folder.path());
  CHECK(storage.BoundsOfRecallable().min_altitude_m == 300.0);
  SiteRow low = SomeSite("f-r3", 50.0, 8.0);
  low.recall = RecallData{true, 20.0, "amsl", 0.7, "{\"glide_ratio\":30}"};
  storage.PutSite(low, "");
  CHECK(storage.BoundsOfRecallable().min_altitude_m == 20.0);
  CHECK(storage.BoundsOfRecallable().aircraft_jsons.size() == 2);
}

TEST_CASE("storage: telemetry is found on both sides of a time, by kind") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
  storage.InsertFlight(SomeFlight("f"));
  storage.PutTelemetry("f",
                       {{TelemetryKind::kPosition, 10, {47.0, 8.0, 400.0, 0.0}},
                        {TelemetryKind::kPosition, 20, {48.0, 8.0, 400.0, 0.0}},
                        {TelemetryKind::kWind, 12, {1.0, 2.0, 0.0, 0.0}}});
  storage.PutTelemetry("f", {{TelemetryKind::kPosition, 20, {49.0, 8.0, 400.0, 0.0}}});
  const auto pair = storage.TelemetryAround("f", TelemetryKind::kPosition, 15);
  REQUIRE(pair.before);
  REQUIRE(pair.after);
  CHECK(pair.before->timestamp_us == 10);
  CHECK(pair.after->values[0] == 49.0);
  CHECK_FALSE(storage.TelemetryAround("f", TelemetryKind::kWind, 15).after);
  CHECK_FALSE(storage.TelemetryAround("f", TelemetryKind::kAttitude, 15).before);
  CHECK(storage.TelemetryAround("f", TelemetryKind::kPosition, 20).before->timestamp_us == 20);
}

TEST_CASE("storage: retired images are gone, unless another flight needs them, and rows stay") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
  storage.InsertFlight(SomeFlight("f"));
  storage.InsertFlight(SomeFlight("g"));
  storage.WriteImage(kImage, "shared");
  storage.WriteImage(kOtherImage, "own");
  FrameRow own = SomeFrame("f", "two");
  own.sha256 = kOtherImage;
  storage.InsertFrames("f", {SomeFrame("f", "one"), own});
  storage.InsertFrames("g", {SomeFrame("g", "one")});
  CHECK(storage.NumImageBytes() == 9);
  storage.RetireImages("f");
  CHECK(storage.ReadImage(kImage));
  CHECK_FALSE(storage.ReadImage(kOtherImage));
  CHECK(storage.NumImageBytes() == 6);
  CHECK(storage.FindFlight("f")->has_retired_images);
  CHECK(storage.ListFrames("f").size() == 2);
}

}  // namespace
}  // namespace freelsd
