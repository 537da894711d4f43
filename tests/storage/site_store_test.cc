#include "storage/site_store.h"

#include <chrono>
#include <future>
#include <memory>
#include <optional>
#include <string>

#include <doctest/doctest.h>

#include "storage/storage.h"
#include "tests/storage/place.h"
#include "tests/storage/rows.h"

namespace freelsd {
namespace {

TEST_CASE("site store: sites are found by box, also across the antimeridian") {
  const StoragePlace place;
  Storage storage(place.options());
  PutSite(storage, SomeSite("home", 50.0, 8.0));
  PutSite(storage, SomeSite("fiji", -17.0, 179.5));
  PutSite(storage, SomeSite("taveuni", -17.0, -179.9));
  CHECK(storage.sites.List(std::nullopt, std::nullopt).size() == 3);
  CHECK(storage.sites.List(std::nullopt, BoundingBox{7.0, 49.0, 9.0, 51.0}).size() == 1);
  CHECK(storage.sites.List(std::nullopt, BoundingBox{179.0, -18.0, -179.0, -16.0}).size() == 2);
  CHECK(storage.sites.List("g", std::nullopt).empty());
  CHECK(storage.sites.List("f", std::nullopt).size() == 3);
}

TEST_CASE("site store: who wants to change sites waits until a turn has ended") {
  const StoragePlace place;
  Storage storage(place.options());
  std::unique_ptr<SiteTurn> turn = storage.sites.TakeTurn();
  std::future<void> other = std::async(
      std::launch::async, [&storage] { PutSite(storage, SomeSite("other", 50.0, 8.0)); });
  CHECK(other.wait_for(std::chrono::milliseconds(200)) == std::future_status::timeout);
  CHECK_FALSE(storage.sites.Find("other"));
  turn->PutEvaluation({{SomeSite("own", 50.0, 8.0)}, {}, {}, {}}, {});
  other.get();
  CHECK(storage.sites.Find("own"));
  CHECK(storage.sites.Find("other"));
  // A turn that is not used ends too, and changes nothing.
  const uint64_t version = storage.sites.Version();
  storage.sites.TakeTurn();
  CHECK(storage.sites.Version() == version);
  CHECK(storage.sites.Delete("own"));
}

TEST_CASE("site store: a site put again replaces what was stored") {
  const StoragePlace place;
  Storage storage(place.options());
  PutSite(storage, SomeSite("s", 50.0, 8.0));
  SiteRow site = SomeSite("s", 51.0, 8.0);
  site.approach_json = "{}";
  PutSite(storage, site);
  CHECK(storage.sites.Find("s")->latitude_deg == 51.0);
  CHECK(storage.sites.Find("s")->approach_json == "{}");
  CHECK(storage.sites.Delete("s"));
  CHECK_FALSE(storage.sites.Delete("s"));
}

// A square of the map keeps its id when the tracks of another evaluation put it in another region.
TEST_CASE("site store: a site put again may lie in another region") {
  const StoragePlace place;
  Storage storage(place.options());
  SiteRow site = SomeSite("s", 50.0, 8.0);
  PutSite(storage, site);
  site.region_id = 4;
  PutSite(storage, site);
  CHECK(storage.sites.Find("s")->region_id == 4);
}

TEST_CASE(
    "site store: recall finds sites by box, also over the antimeridian, and forgets deleted ones") {
  const StoragePlace place;
  Storage storage(place.options());
  SiteRow site = SomeSite("fiji", -17.0, 179.95);
  site.recall = RecallData{true, 10.0, "amsl", 0.5, "{}"};
  PutSite(storage, site);
  site = SomeSite("taveuni", -17.0, -179.9);
  site.recall = RecallData{false, 20.0, "amsl", 0.4, "{}"};
  site.map_box = BoundingBox{-179.95, -17.1, -179.5, -16.9};
  PutSite(storage, site);
  PutSite(storage, SomeSite("rejected", -17.0, 179.95));
  CHECK(storage.sites.ListRecallable({179.9, -18.0, -179.8, -16.0}).size() == 2);
  CHECK(storage.sites.ListRecallable({179.0, -18.0, 180.0, -16.0}).size() == 1);
  // By the map's extent, not the touchdown.
  CHECK(storage.sites.ListRecallable({-179.6, -18.0, -179.4, -16.0}).size() == 1);
  CHECK(storage.sites.ListRecallable({0.0, -18.0, 10.0, -16.0}).empty());
  // Rejected at the next evaluation: no longer recalled.
  site.recall.reset();
  PutSite(storage, site);
  CHECK(storage.sites.ListRecallable({-180.0, -90.0, 180.0, 90.0}).size() == 1);
  storage.sites.Delete("fiji");
  CHECK(storage.sites.ListRecallable({-180.0, -90.0, 180.0, 90.0}).empty());
}

TEST_CASE("site store: a superseded site is not recalled, until what superseded it is gone") {
  const StoragePlace place;
  Storage storage(place.options());
  SiteRow old_site = SomeSite("f-r1", 50.0, 8.0);
  old_site.recall = RecallData{true, 300.0, "amsl", 0.7, "{}"};
  PutSite(storage, old_site);
  SiteRow new_site = old_site;
  new_site.id = std::string("g-r1");
  new_site.flight_id = std::string("g");
  Standing superseded;
  superseded.superseded_by = std::string("g-r1");
  superseded.superseded_at_us = 2000;
  superseded.superseded_reason = std::string("approach_blocked");
  superseded.confirmed_at_us = 1500;
  PutSite(storage, new_site, {{"f-r1", superseded}});
  const BoundingBox box{7.0, 49.0, 9.0, 51.0};
  REQUIRE(storage.sites.ListRecallable(box).size() == 1);
  CHECK(storage.sites.ListRecallable(box)[0]->site_id == "g-r1");
  CHECK((static_cast<Standing>(*storage.sites.Find("f-r1")) == superseded));
  CHECK(storage.sites.CountOverruled(box) == 1);
  CHECK(storage.sites.ListDependents("g-r1") == std::vector<std::string>{"f-r1"});
  Standing confirmed;
  confirmed.confirmed_at_us = 1500;
  CHECK_FALSE(storage.sites.Delete("none", {{"f-r1", confirmed}}));
  CHECK(storage.sites.ListRecallable(box).size() == 1);
  CHECK(storage.sites.Delete("g-r1", {{"f-r1", confirmed}}));
  REQUIRE(storage.sites.ListRecallable(box).size() == 1);
  CHECK(storage.sites.ListRecallable(box)[0]->site_id == "f-r1");
  CHECK(storage.sites.ListRecallable(box)[0]->seen_at_us == 1500);
  CHECK_FALSE(storage.sites.Find("f-r1")->superseded_by);
}

TEST_CASE("site store: what bounds the reach of sites follows them") {
  const StoragePlace place;
  Storage storage(place.options());
  SiteRow high = SomeSite("f-r1", 50.0, 8.0);
  high.recall = RecallData{true, 300.0, "amsl", 0.7, "{}"};
  PutSite(storage, high);
  CHECK(storage.sites.BoundsOfRecallable().min_altitude_m == 300.0);
  SiteRow low = SomeSite("f-r3", 50.0, 8.0);
  low.recall = RecallData{true, 20.0, "amsl", 0.7, "{\"glide_ratio\":30}"};
  PutSite(storage, low);
  CHECK(storage.sites.BoundsOfRecallable().min_altitude_m == 20.0);
  CHECK(storage.sites.BoundsOfRecallable().aircraft_jsons.size() == 2);
}

}  // namespace
}  // namespace freelsd
