#include "storage/storage.h"

#include <filesystem>
#include <string>
#include <string_view>

#include <doctest/doctest.h>

#include "tests/storage/place.h"
#include "tests/storage/rows.h"

namespace freelsd {
namespace {

TEST_CASE("storage: what was stored is there after opening the folder again") {
  const StoragePlace place;
  {
    Storage storage(place.options());
    storage.flights.Insert(SomeFlight("f"));
    storage.images.Write(kImage, std::string_view("pixels\0more", 11));
    storage.frames.Insert("f", {SomeFrame("f", "one"), SomeFrame("f", "two")}, SomeJob("j", "f"));
    const std::string tile("map\0blob", 8);
    storage.maps.Stage(SomeMap("f/1", "f", {7.9, 49.9, 8.1, 50.1}), {{{0, 0, 0}, tile}}, {});
    SiteRow site = SomeSite("f-r3", 50.0, 8.0);
    site.map_id = "f/1";
    storage.sites.PutEvaluation({{site}, {}, {"f/1"}, {}}, {});
  }
  const Storage storage(place.options());
  REQUIRE(storage.flights.Find("f"));
  CHECK(storage.flights.Find("f")->created_at_us == 1700000000000000);
  CHECK(storage.images.Read(kImage) == std::string("pixels\0more", 11));
  CHECK(storage.frames.List("f").size() == 2);
  CHECK(storage.frames.List("f")[1].sequence == 2);
  CHECK(storage.jobs.Find("j")->kind == "batch");
  CHECK(storage.sites.Find("f-r3")->map_id == "f/1");
  CHECK(storage.maps.ReadTile("f/1", {0, 0, 0}) == std::string("map\0blob", 8));
}

TEST_CASE("storage: a second process is refused while the folder is in use") {
  const StoragePlace place;
  const Storage storage(place.options());
  CHECK_THROWS_WITH_AS(
      Storage(place.options()), doctest::Contains("another freelsd-server"), StorageError);
}

TEST_CASE("storage: the kind of database is known") {
  const StoragePlace place;
  CHECK(Storage(place.options()).Kind() == StoragePlace::Kind());
}

TEST_CASE("storage: a fresh folder can be written") {
  const StoragePlace place;
  const Storage storage(place.options());
  CHECK_FALSE(storage.WhyNotWritable());
  CHECK(std::filesystem::is_empty(storage.SpoolFolder()));
}

}  // namespace
}  // namespace freelsd
