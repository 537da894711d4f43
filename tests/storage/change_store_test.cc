#include "storage/change_store.h"

#include <limits>

#include <doctest/doctest.h>

#include "storage/storage.h"
#include "tests/storage/place.h"
#include "tests/storage/rows.h"

namespace freelsd {
namespace {

constexpr int64_t kNowUs = 1700000000000000;

ObstacleRow Wire(const std::string& id, BoundingBox box = {7.0, 46.0, 7.1, 46.1}) {
  return {id, R"({"a":1})", box, std::nullopt, kNowUs};
}

SiteRow StampedSite(const std::string& id, double longitude_deg, int64_t updated_at_us) {
  SiteRow site = SomeSite(id, 47.0, longitude_deg);
  site.updated_at_us = updated_at_us;
  return site;
}

// "<id> <kind>" of all changes after the number.
std::vector<std::string> TextsAfter(const Storage& storage,
                                    int64_t number,
                                    const std::optional<ChangeArea>& area = std::nullopt) {
  std::vector<std::string> texts;
  for (const ChangeRow& change : storage.changes.List(number, 100, area).changes) {
    texts.push_back(change.key.id + " " + std::to_string(static_cast<int>(change.kind)));
  }
  return texts;
}

using Texts = std::vector<std::string>;

TEST_CASE("changes: each subject has one row with its last change, in the order of the commits") {
  const StoragePlace place;
  Storage storage(place.options());
  PutSite(storage, StampedSite("a", 8.0, 1));
  PutSite(storage, StampedSite("b", 8.0, 1));
  CHECK(TextsAfter(storage, 0) == Texts{"a 0", "b 0"});
  const int64_t second = storage.changes.LastNumber();
  PutSite(storage, StampedSite("a", 8.0, 2));
  CHECK(TextsAfter(storage, 0) == Texts{"b 0", "a 1"});
  CHECK(TextsAfter(storage, second) == Texts{"a 1"});
  Standing superseded;
  superseded.superseded_by = "f2";
  superseded.superseded_at_us = 5;
  Standing confirmed;
  confirmed.confirmed_at_us = 6;
  storage.sites.SetStandings({{"a", superseded}, {"b", confirmed}});
  CHECK(TextsAfter(storage, second) == Texts{"a 2", "b 3"});
  const int64_t fourth = storage.changes.LastNumber();
  storage.sites.SetStandings({{"a", superseded}});
  CHECK(TextsAfter(storage, fourth).empty());
  storage.sites.Delete("b");
  CHECK(TextsAfter(storage, fourth) == Texts{"b 4"});
  const auto removed = storage.changes.Find({ChangeSubject::kSite, "b"});
  REQUIRE(removed);
  CHECK(removed->stamp_us == 1);
  PutSite(storage, StampedSite("b", 8.0, 3));
  CHECK(TextsAfter(storage, fourth) == Texts{"b 0"});
}

TEST_CASE("changes: a map is told when it comes in force, with the sites on it, and when it goes") {
  const StoragePlace place;
  Storage storage(place.options());
  const FlightMapRow map = SomeMap(storage.maps.NewId("f"), "f", {7.9, 46.9, 8.1, 47.1});
  storage.maps.Stage(map, {{{0, 0, 0}, "tile"}, {{1, 0, -1}, "coarse"}}, {});
  CHECK(TextsAfter(storage, 0).empty());
  SiteRow site = StampedSite("f-r1", 8.0, 1);
  site.map_id = map.id;
  storage.sites.PutEvaluation({{site}, {}, {map.id}, {}}, {});
  CHECK(TextsAfter(storage, 0) == Texts{"f/1 0", "f-r1 0"});
  CHECK(storage.maps.ListTiles(map.id) == std::vector<TileKey>{{0, 0, 0}, {1, 0, -1}});
  storage.sites.PutEvaluation({{}, {"f-r1"}, {}, {map.id}}, {});
  CHECK(TextsAfter(storage, 0) == Texts{"f-r1 4", "f/1 4"});
}

TEST_CASE("changes: obstacles are told when put, deleted and expired") {
  const StoragePlace place;
  Storage storage(place.options());
  ObstacleRow people = Wire("people");
  people.expires_at_us = kNowUs + 5;
  storage.obstacles.Put({Wire("wire"), people}, kNowUs);
  CHECK(TextsAfter(storage, 0) == Texts{"wire 0", "people 0"});
  storage.obstacles.Put({Wire("wire")}, kNowUs + 6);
  storage.obstacles.Delete("wire");
  CHECK(TextsAfter(storage, 0) == Texts{"people 5", "wire 4"});
}

TEST_CASE("changes: pages end at their limit and go on where they ended") {
  const StoragePlace place;
  Storage storage(place.options());
  storage.obstacles.Put({Wire("a"), Wire("b"), Wire("c")}, kNowUs);
  const ChangePage first = storage.changes.List(0, 2, std::nullopt);
  CHECK(first.changes.size() == 2);
  CHECK(first.has_more);
  const ChangePage second = storage.changes.List(first.last_number, 2, std::nullopt);
  REQUIRE(second.changes.size() == 1);
  CHECK(second.changes[0].key.id == "c");
  CHECK_FALSE(second.has_more);
  CHECK(second.last_number == storage.changes.LastNumber());
}

TEST_CASE("changes: an area has what is in it and what has left it") {
  const StoragePlace place;
  Storage storage(place.options());
  PutSite(storage, StampedSite("inside", 8.0, 1));
  PutSite(storage, StampedSite("outside", 9.0, 1));
  storage.obstacles.Put({Wire("around", {8.15, 47.0, 8.2, 47.0}), Wire("far")}, kNowUs);
  const ChangeArea area{{7.9, 46.9, 8.1, 47.1}, {7.8, 46.8, 8.2, 47.2}};
  CHECK(TextsAfter(storage, 0, area) == Texts{"inside 0", "around 0"});
  PutSite(storage, StampedSite("inside", 8.5, 2));
  CHECK(TextsAfter(storage, 0, area) == Texts{"around 0", "inside 1"});
  const ChangeArea across{{170.0, 46.0, 8.01, 48.0}, {170.0, 46.0, 8.01, 48.0}};
  CHECK(TextsAfter(storage, 0, across) == Texts{"far 0", "inside 1"});
}

TEST_CASE("changes: removals are forgotten by age, and the feed says up to which number") {
  const StoragePlace place;
  Storage storage(place.options());
  storage.obstacles.Put({Wire("a"), Wire("b")}, kNowUs);
  storage.obstacles.Delete("a");
  const int64_t removal = storage.changes.LastNumber();
  storage.changes.ForgetRemoved(0);
  CHECK(storage.changes.ForgottenThrough() == 0);
  storage.changes.ForgetRemoved(std::numeric_limits<int64_t>::max());
  CHECK(storage.changes.ForgottenThrough() == removal);
  CHECK(storage.changes.LastNumber() == removal);
  CHECK(TextsAfter(storage, 0) == Texts{"b 0"});
  storage.obstacles.Put({Wire("c")}, kNowUs);
  CHECK(storage.changes.LastNumber() > removal);
}

TEST_CASE("changes: the feed keeps its id and its numbers over a start") {
  const StoragePlace place;
  std::string id;
  int64_t number = 0;
  {
    Storage storage(place.options());
    storage.obstacles.Put({Wire("a")}, kNowUs);
    id = storage.changes.FeedId();
    number = storage.changes.LastNumber();
    storage.changes.Repeat({{ChangeSubject::kObstacle, "a"}});
    CHECK(TextsAfter(storage, number) == Texts{"a 0"});
  }
  const Storage storage(place.options());
  CHECK(storage.changes.FeedId() == id);
  CHECK(storage.changes.LastNumber() == number + 1);
}

TEST_CASE("changes: a removal of what is not here is kept, of what is here it changes nothing") {
  const StoragePlace place;
  Storage storage(place.options());
  ChangeRow removal;
  removal.key = {ChangeSubject::kObstacle, "a"};
  removal.kind = ChangeKind::kRemoved;
  removal.stamp_us = 7;
  removal.origin = "elsewhere";
  storage.changes.PutRemoval(removal);
  CHECK(storage.changes.Find(removal.key)->stamp_us == 7);
  removal.stamp_us = 6;
  storage.changes.PutRemoval(removal);
  CHECK(storage.changes.Find(removal.key)->stamp_us == 7);
  storage.obstacles.Put({Wire("a")}, kNowUs);
  storage.changes.PutRemoval(removal);
  CHECK(TextsAfter(storage, 0) == Texts{"a 0"});
}

TEST_CASE("changes: a whole site has what recall reads") {
  const StoragePlace place;
  Storage storage(place.options());
  SiteRow site = StampedSite("a", 8.0, 1);
  site.recall = RecallData{true, 400.0, "amsl", 0.5, R"({"b":2})"};
  site.map_box = BoundingBox{7.75, 46.75, 8.25, 47.25};
  PutSite(storage, site);
  const auto whole = storage.sites.FindWhole("a");
  REQUIRE(whole);
  REQUIRE(whole->recall);
  CHECK(whole->recall->is_landable);
  CHECK(whole->recall->altitude_m == 400.0);
  CHECK(whole->recall->aircraft_json == R"({"b":2})");
  CHECK(whole->map_box->west_deg == 7.75);
  CHECK(whole->map_box->north_deg == 47.25);
  CHECK_FALSE(storage.sites.FindWhole("b"));
}

TEST_CASE("changes: a follower knows what the followed server does not know") {
  const TemporaryFolder folder;
  Storage storage(folder.path());
  PutSite(storage, StampedSite("own", 8.0, 1));
  EvaluationRows rows;
  rows.sites = {StampedSite("told", 8.0, 1)};
  rows.is_from_above = true;
  storage.sites.PutEvaluation(rows, {});
  storage.obstacles.Merge({{Wire("wire")}, {}, true});
  std::vector<ChangeRow> unknown = storage.changes.ListUnknownAbove(10);
  REQUIRE(unknown.size() == 1);
  CHECK(unknown[0].key.id == "own");
  // Changed meanwhile: what was sent is not what is here.
  PutSite(storage, StampedSite("own", 8.0, 2));
  storage.changes.SetKnownAbove(unknown);
  unknown = storage.changes.ListUnknownAbove(10);
  REQUIRE(unknown.size() == 1);
  storage.changes.SetKnownAbove(unknown);
  CHECK(storage.changes.ListUnknownAbove(10).empty());
  storage.obstacles.Merge({{}, {{"wire", kNowUs}}, true});
  CHECK(storage.changes.ListUnknownAbove(10).empty());
  storage.obstacles.Put({Wire("wire")}, kNowUs);
  CHECK(storage.changes.ListUnknownAbove(10).size() == 1);
  storage.changes.SetKnownAbove(storage.changes.ListUnknownAbove(10));
  ChangeRow told;
  told.key = {ChangeSubject::kSite, "told"};
  told.origin = "centre";
  storage.changes.SetOrigins({told});
  storage.changes.SetAllUnknownAbove("centre");
  CHECK(storage.changes.ListUnknownAbove(10).size() == 2);
}

TEST_CASE("changes: where a follower goes on survives a start") {
  const TemporaryFolder folder;
  { Storage(folder.path()).changes.PutFollowState({"http://centre", "abc-7", 5}); }
  const Storage storage(folder.path());
  const auto state = storage.changes.FindFollowState();
  REQUIRE(state);
  CHECK(state->followed == "http://centre");
  CHECK(state->next == "abc-7");
  CHECK(state->in_step_at_us == 5);
}

}  // namespace
}  // namespace freelsd
