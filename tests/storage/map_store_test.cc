#include <doctest/doctest.h>

#include "storage/storage.h"
#include "tests/storage/antimeridian.h"
#include "tests/storage/place.h"
#include "tests/storage/rows.h"

namespace freelsd {
namespace {

constexpr BoundingBox kHere{8.0, 50.0, 8.01, 50.01};
constexpr BoundingBox kAround{7.9, 49.9, 8.1, 50.1};

TEST_CASE("maps: a staged map counts only once an evaluation puts it in force, with its sites") {
  const StoragePlace place;
  Storage storage(place.options());
  CHECK(storage.maps.NewId("f") == "f/1");
  storage.images.Write("ab", "picture");
  const uint64_t before = storage.sites.Version();
  storage.maps.Stage(SomeMap("f/1", "f", kHere), {{{0, -1, 2}, "tile"}}, {{{0, 0, 0}, "ab"}});
  storage.maps.StageTiles("f/1", {{{1, 0, 0}, "coarse"}}, {});
  CHECK(storage.sites.Version() == before);
  CHECK(storage.maps.ListOf("f").empty());
  CHECK(storage.sites.ListMaps(kAround).empty());
  SiteRow site = SomeSite("f-r1", 50.0, 8.0);
  site.map_id = "f/1";
  site.recall = RecallData{};
  storage.sites.PutEvaluation({{site}, {}, {"f/1"}, {}}, {});
  CHECK(storage.sites.Version() > before);
  REQUIRE(storage.maps.ListOf("f").size() == 1);
  CHECK(storage.maps.Find("f/1")->altitude_datum == "amsl");
  CHECK(storage.maps.ReadTile("f/1", {0, -1, 2}) == "tile");
  CHECK(storage.maps.ReadTile("f/1", {1, 0, 0}) == "coarse");
  CHECK(storage.maps.ReadTileCopy("f/1", {0, -1, 2}) == "tile");
  CHECK_FALSE(storage.maps.ReadTile("f/1", {0, 0, 0}));
  CHECK(storage.maps.FindPhotoTile("f/1", {0, 0, 0}) == "ab");
  const auto rows = storage.sites.ListMaps(kAround);
  REQUIRE(rows.size() == 1);
  CHECK(rows[0]->id == "f/1");
  CHECK(storage.sites.Find("f-r1")->map_id == "f/1");
  CHECK(storage.sites.ListAccepted(kAround) == std::vector<std::string>{"f-r1"});
}

TEST_CASE("maps: an unfinished map is gone after a restart, and its picture's files too") {
  const StoragePlace place;
  {
    Storage storage(place.options());
    storage.images.Write("ab01", "picture");
    storage.maps.Stage(SomeMap("f/1", "f", kHere), {{{0, 0, 0}, "tile"}}, {{{0, 0, 0}, "ab01"}});
  }
  const Storage storage(place.options());
  CHECK_FALSE(storage.maps.ReadTile("f/1", {0, 0, 0}));
  CHECK_FALSE(storage.images.Read("ab01"));
}

TEST_CASE("maps: a picture's rows may come before its files, which they then keep") {
  const StoragePlace place;
  Storage storage(place.options());
  storage.images.Write("ab02", "also another flight's");
  storage.maps.Stage(SomeMap("f/1", "f", kHere), {}, {});
  storage.maps.StageTiles("f/1", {}, {{{0, 0, 0}, "ab01"}, {{0, 0, 1}, "ab02"}});
  storage.images.RemoveUnused("ab02");
  CHECK(storage.images.Read("ab02") == "also another flight's");
  CHECK_FALSE(storage.images.Read("ab01"));
  storage.images.Write("ab01", "picture");
  storage.sites.PutEvaluation({{}, {}, {"f/1"}, {}}, {});
  CHECK(storage.images.Read("ab01") == "picture");
  CHECK(storage.maps.FindPhotoTile("f/1", {0, 0, 0}) == "ab01");
  storage.sites.PutEvaluation({{}, {}, {}, {"f/1"}}, {});
  CHECK_FALSE(storage.images.Read("ab01"));
}

TEST_CASE("maps: they outlive their flight unless its sites are forgotten") {
  for (const bool forget : {false, true}) {
    const StoragePlace place;
    Storage storage(place.options());
    storage.flights.Insert(SomeFlight("f"));
    storage.images.Write("ab01", "picture");
    storage.maps.Stage(SomeMap("f/1", "f", kHere), {{{0, 0, 0}, "tile"}}, {{{0, 0, 0}, "ab01"}});
    storage.sites.PutEvaluation({{}, {}, {"f/1"}, {}}, {});
    storage.images.RemoveUnused("ab01");
    CHECK(storage.images.Read("ab01") == "picture");
    EvaluationRows rows;
    rows.deleted_flight = "f";
    if (forget) rows.forgotten_maps = {"f/1"};
    storage.sites.PutEvaluation(rows, {});
    CHECK_FALSE(storage.flights.Find("f"));
    CHECK(storage.maps.ListOf("f").empty() == forget);
    CHECK(storage.images.Read("ab01").has_value() != forget);
  }
}

TEST_CASE("maps: pictures can be removed without the map") {
  const StoragePlace place;
  Storage storage(place.options());
  storage.images.Write("ab01", "picture");
  storage.images.Write("ab02", "shared");
  storage.maps.Stage(SomeMap("f/1", "f", kHere), {}, {{{0, 0, 0}, "ab01"}, {{0, 0, 1}, "ab02"}});
  storage.maps.Stage(SomeMap("g/1", "g", kHere), {}, {{{0, 0, 0}, "ab02"}});
  storage.sites.PutEvaluation({{}, {}, {"f/1", "g/1"}, {}}, {});
  CHECK(storage.maps.ListFlightsWithPhotoTiles() == std::vector<std::string>{"f", "g"});
  CHECK(storage.maps.CountPhotoTiles("f/1") == std::vector<int64_t>{2});
  CHECK(storage.maps.ListPhotoTiles("f/1", 0).size() == 2);
  storage.maps.RemovePhotoTiles("f");
  CHECK(storage.maps.ListPhotoTiles("f/1", 0).empty());
  CHECK(storage.maps.ListOf("f").size() == 1);
  CHECK_FALSE(storage.images.Read("ab01"));
  CHECK(storage.images.Read("ab02") == "shared");
}

TEST_CASE("maps: an evaluation replaces sites and maps") {
  const StoragePlace place;
  Storage storage(place.options());
  storage.maps.Stage(SomeMap("f/1", "f", kHere), {{{0, 0, 0}, "old"}}, {});
  storage.sites.PutEvaluation({{SomeSite("f-r1", 50.0, 8.0)}, {}, {"f/1"}, {}}, {});
  storage.maps.Stage(SomeMap("f/2", "f", kHere), {{{0, 0, 0}, "new"}}, {});
  storage.sites.PutEvaluation({{SomeSite("f-r2", 50.0, 8.0)}, {"f-r1"}, {"f/2"}, {"f/1"}}, {});
  CHECK_FALSE(storage.sites.Find("f-r1"));
  CHECK(storage.sites.Find("f-r2"));
  REQUIRE(storage.maps.ListOf("f").size() == 1);
  CHECK(storage.maps.ReadTile("f/2", {0, 0, 0}) == "new");
  CHECK_FALSE(storage.maps.ReadTile("f/1", {0, 0, 0}));
}

TEST_CASE("maps: a new id is the flight's highest, also beside maps that are stored") {
  const StoragePlace place;
  {
    Storage storage(place.options());
    CHECK(storage.maps.NewId("f") == "f/1");
    storage.maps.Stage(SomeMap("f/7", "f", kHere), {}, {});
    storage.sites.PutEvaluation({{}, {}, {"f/7"}, {}}, {});
    CHECK(storage.maps.NewId("f") == "f/8");
    CHECK(storage.maps.NewId("g") == "g/1");
  }
  Storage storage(place.options());
  CHECK(std::stoi(storage.maps.NewId("f").substr(2)) > 7);
}

TEST_CASE("maps: ids of a flight that is forgotten after a restart are not given again") {
  const StoragePlace place;
  {
    Storage storage(place.options());
    const std::string id = storage.maps.NewId("f");
    storage.maps.Stage(SomeMap(id, "f", kHere), {}, {});
    storage.sites.PutEvaluation({{}, {}, {id}, {}}, {});
  }
  Storage storage(place.options());
  storage.sites.PutEvaluation({{}, {}, {}, {"f/1"}}, {});
  CHECK(storage.maps.ListOf("f").empty());
  CHECK(storage.maps.NewId("f") != "f/1");
}

TEST_CASE("maps: a map across the antimeridian is found at its own ground and nowhere else") {
  const StoragePlace place;
  Storage storage(place.options());
  PutAcross(storage);
  CheckFoundAcross(storage);
}

}  // namespace
}  // namespace freelsd
