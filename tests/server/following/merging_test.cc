// What several servers tell comes out the same in every order.
#include <algorithm>
#include <numeric>
#include <random>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/server/following/simulated_flight.h"
#include "tests/storage/place.h"
#include "tests/storage/temporary_folder.h"

namespace freelsd {
namespace {

constexpr int64_t kFirst = 1600000000000000;
constexpr int64_t kMinute = 60000000;

ToldChange Wire(int64_t updated_at_us, double latitude_deg, const std::string& id = "wire") {
  ToldChange told;
  told.change.key = {ChangeSubject::kObstacle, id};
  told.change.stamp_us = updated_at_us;
  told.obstacle = ObstacleRow{
      id,
      nlohmann::json{{"type", "Feature"},
                     {"geometry", {{"type", "Point"}, {"coordinates", {8.0, latitude_deg}}}},
                     {"properties", {{"kind", "mast"}, {"height_m", 30}}}}
          .dump(),
      {8.0, latitude_deg, 8.0, latitude_deg},
      std::nullopt,
      updated_at_us};
  return told;
}

ToldChange Removal(ChangeSubject subject, const std::string& id, int64_t stamp_us) {
  ToldChange told;
  told.change.key = {subject, id};
  told.change.kind = ChangeKind::kRemoved;
  told.change.stamp_us = stamp_us;
  told.change.origin = "elsewhere";
  return told;
}

// One change at a time, as it may arrive, and the bytes of all maps.
struct Arrivals {
  std::vector<std::vector<ToldChange>> changes;
  std::map<std::string, std::string> map_bytes;

  void Add(const SimulatedFlight& flight) {
    ToldFlight told = Fly(flight);
    for (const ToldChange& change : told.changes) changes.push_back({change});
    map_bytes.merge(told.map_bytes);
  }
};

// Two edges and a centre over one field: a site, a later wall, later free ground without a site, a
// simultaneous flight, and obstacles.
Arrivals SameGround() {
  Arrivals all;
  all.Add({.id = "a", .seen_at_us = kFirst, .origin = "one"});
  all.Add({.id = "b", .seen_at_us = kFirst + kMinute, .origin = "other"});
  all.Add({.id = "wall",
           .seen_at_us = kFirst + 2 * kMinute,
           .field = FieldState::kWalled,
           .has_site = false,
           .origin = "one"});
  all.Add({.id = "c", .seen_at_us = kFirst + 3 * kMinute, .origin = "other"});
  all.changes.push_back({Wire(5, 47.1)});
  all.changes.push_back({Wire(7, 47.2)});
  all.changes.push_back({Removal(ChangeSubject::kObstacle, "wire", 5)});
  return all;
}

void StageAll(Storage& storage, const Arrivals& all) {
  for (const auto& [id, bytes] : all.map_bytes) {
    const TakenMap taken = ParseMapBytes(bytes, id);
    storage.maps.Stage(taken.map, taken.tiles, {});
  }
}

struct Server {
  TemporaryFolder folder;
  Storage storage{folder.path()};
  MapCache maps{{size_t{1} << 26, size_t{1} << 22}};
};

// What is left of the order: a change whose map is not here yet waits.
void TakeInOrder(Storage& storage, MapCache& maps, std::vector<std::vector<ToldChange>> waiting) {
  while (!waiting.empty()) {
    const size_t before = waiting.size();
    std::vector<std::vector<ToldChange>> later;
    for (const auto& changes : waiting) {
      try {
        MergeFromBelow(storage, maps, changes);
      } catch (const ApiError& error) {
        REQUIRE(error.code() == "MapMissing");
        later.push_back(changes);
      }
    }
    REQUIRE(later.size() < before);
    waiting = later;
  }
}

// Everything that is told, but the numbers and the words for the changes.
std::string StateOf(const Storage& storage) {
  std::map<std::string, nlohmann::json> all;
  for (const ChangeRow& change : storage.changes.List(0, 1000, std::nullopt).changes) {
    const std::optional<ToldChange> told = ReadTold(storage, change);
    REQUIRE(told);
    nlohmann::json json = ToldJson(*told, "here");
    json.erase("number");
    if (!told->IsRemoval()) json.erase("change");
    all[json["subject"].get<std::string>() + " " + change.key.id] = json;
  }
  return nlohmann::json(all).dump(1);
}

TEST_CASE("merging: two edges that saw the same ground come out the same in every order") {
  const Arrivals all = SameGround();
  std::string expected;
  std::mt19937 random(3);
  for (int i = 0; i < 40; ++i) {
    std::vector<std::vector<ToldChange>> order = all.changes;
    if (i > 0) std::shuffle(order.begin(), order.end(), random);
    Server server;
    StageAll(server.storage, all);
    TakeInOrder(server.storage, server.maps, order);
    const std::string state = StateOf(server.storage);
    if (i == 0) {
      expected = state;
      // The wall is later than two of the sites, and no site lies on its map.
      CHECK(server.storage.sites.Find("a-r1")->superseded_by == "wall");
      CHECK(server.storage.sites.Find("b-r1")->superseded_by == "wall");
      CHECK_FALSE(server.storage.sites.Find("c-r1")->superseded_by);
      CHECK(server.storage.obstacles.Find("wire")->updated_at_us == 7);
    }
    CHECK(state == expected);
  }
}

TEST_CASE("merging: a map that comes before its sites names them once they are here") {
  Arrivals all;
  all.Add({.id = "a", .seen_at_us = kFirst});
  all.Add({.id = "wall", .seen_at_us = kFirst + kMinute, .field = FieldState::kWalled});
  REQUIRE(all.changes.size() == 4);
  for (const std::vector<size_t>& order :
       {std::vector<size_t>{0, 1, 2, 3}, {2, 0, 1, 3}, {2, 3, 0, 1}}) {
    Server server;
    StageAll(server.storage, all);
    for (const size_t i : order) MergeFromBelow(server.storage, server.maps, all.changes[i]);
    CHECK(server.storage.sites.Find("a-r1")->superseded_by == "wall-r1");
  }
}

TEST_CASE("merging: versions with one stamp are settled by the evidence, in both orders") {
  std::vector<ToldChange> versions = Fly({.id = "a", .seen_at_us = kFirst}).changes;
  ToldChange site = versions[1];
  const auto with_digest = [&site](const std::string& digest) {
    ToldChange other = site;
    nlohmann::json feature = nlohmann::json::parse(site.site->feature_json);
    feature["properties"]["evidence_digest"] = digest;
    other.site->feature_json = feature.dump();
    return other;
  };
  const ToldFlight flight = Fly({.id = "a", .seen_at_us = kFirst});
  for (const bool is_first_higher : {false, true}) {
    Server server;
    const TakenMap map = ParseMapBytes(flight.map_bytes.at("a/1"), "a/1");
    server.storage.maps.Stage(map.map, map.tiles, {});
    MergeFromBelow(server.storage, server.maps, {versions[0]});
    MergeFromBelow(server.storage, server.maps, {with_digest(is_first_higher ? "bb" : "aa")});
    MergeFromBelow(server.storage, server.maps, {with_digest(is_first_higher ? "aa" : "bb")});
    CHECK(server.storage.sites.Find("a-r1")->feature_json.find("\"bb\"") != std::string::npos);
  }
}

TEST_CASE("merging: a removal removes the version that it knew, not a later one, in both orders") {
  const std::vector<std::vector<ToldChange>> orders[] = {
      {{Wire(5, 47.1)}, {Wire(6, 47.2)}, {Removal(ChangeSubject::kObstacle, "wire", 5)}},
      {{Removal(ChangeSubject::kObstacle, "wire", 5)}, {Wire(5, 47.1)}, {Wire(6, 47.2)}}};
  for (const auto& order : orders) {
    Server server;
    for (const auto& changes : order) MergeFromBelow(server.storage, server.maps, changes);
    CHECK(server.storage.obstacles.Find("wire"));
  }
  Server server;
  MergeFromBelow(server.storage, server.maps, {Removal(ChangeSubject::kObstacle, "wire", 6)});
  MergeFromBelow(server.storage, server.maps, {Wire(5, 47.1)});
  MergeFromBelow(server.storage, server.maps, {Wire(6, 47.2)});
  CHECK_FALSE(server.storage.obstacles.Find("wire"));
}

TEST_CASE("merging: without its map nothing is taken, and the answer names the map") {
  Server server;
  const ToldFlight flight = Fly({.id = "a", .seen_at_us = kFirst});
  try {
    MergeFromBelow(server.storage, server.maps, flight.changes);
    FAIL("the map was not missed");
  } catch (const ApiError& error) {
    CHECK(error.code() == "MapMissing");
    REQUIRE(error.errors().size() == 1);
    CHECK(error.errors()[0].detail == "a/1");
  }
  CHECK_FALSE(server.storage.sites.Find("a-r1"));
}

TEST_CASE("merging: what was told again changes nothing") {
  Server server;
  const Arrivals all = SameGround();
  StageAll(server.storage, all);
  TakeInOrder(server.storage, server.maps, all.changes);
  const std::string state = StateOf(server.storage);
  TakeInOrder(server.storage, server.maps, all.changes);
  CHECK(StateOf(server.storage) == state);
}

// Tells all that one storage has to another, as a followed server does.
void TellAll(const Storage& from, Server& to) {
  std::vector<ToldChange> changes;
  for (const ChangeRow& change : from.changes.List(0, 1000, std::nullopt).changes) {
    changes.push_back(ParseTold(ToldJson(*ReadTold(from, change), from.changes.FeedId()), ""));
  }
  for (const std::string& id : MapsToFetch(to.storage, changes)) {
    const TakenMap taken = ParseMapBytes(MapBytes(from, *from.maps.Find(id)), id);
    to.storage.maps.Stage(taken.map, taken.tiles, {});
  }
  MergeFromAbove(to.storage, to.maps, changes);
}

TEST_CASE("merging: a copy is never safer than an own map that the centre does not know yet") {
  Server centre, edge;
  Arrivals site, wall;
  site.Add({.id = "a", .seen_at_us = kFirst});
  wall.Add({.id = "wall",
            .seen_at_us = kFirst + kMinute,
            .field = FieldState::kWalled,
            .has_site = false});
  StageAll(centre.storage, site);
  TakeInOrder(centre.storage, centre.maps, site.changes);
  StageAll(edge.storage, wall);
  TakeInOrder(edge.storage, edge.maps, wall.changes);
  TellAll(centre.storage, edge);
  CHECK(edge.storage.sites.Find("a-r1")->superseded_by == "wall");
  // Told again as landable, it stays superseded.
  centre.storage.changes.Repeat({{ChangeSubject::kSite, "a-r1"}});
  TellAll(centre.storage, edge);
  CHECK(edge.storage.sites.Find("a-r1")->superseded_by == "wall");
  // The centre gets the map and the site whose standing the edge has changed.
  std::vector<std::string> unknown;
  for (const ChangeRow& change : edge.storage.changes.ListUnknownAbove(10)) {
    unknown.push_back(change.key.id);
  }
  std::sort(unknown.begin(), unknown.end());
  CHECK(unknown == std::vector<std::string>{"a-r1", "wall/1"});
}

TEST_CASE("merging: a told map supersedes a site that the centre does not know yet") {
  Server centre, edge;
  Arrivals site, wall;
  site.Add({.id = "a", .seen_at_us = kFirst});
  wall.Add({.id = "wall",
            .seen_at_us = kFirst + kMinute,
            .field = FieldState::kWalled,
            .has_site = false});
  StageAll(edge.storage, site);
  TakeInOrder(edge.storage, edge.maps, site.changes);
  StageAll(centre.storage, wall);
  TakeInOrder(centre.storage, centre.maps, wall.changes);
  TellAll(centre.storage, edge);
  CHECK(edge.storage.sites.Find("a-r1")->superseded_by == "wall");
  CHECK(edge.storage.changes.ListUnknownAbove(10).size() == 2);
}

TEST_CASE("merging: a copy begun anew keeps what was made here and drops what is told no more") {
  Server centre, edge;
  Arrivals told, own;
  told.Add({.id = "told", .seen_at_us = kFirst});
  own.Add({.id = "own", .longitude_deg = 8.1, .seen_at_us = kFirst});
  StageAll(centre.storage, told);
  TakeInOrder(centre.storage, centre.maps, told.changes);
  TellAll(centre.storage, edge);
  StageAll(edge.storage, own);
  TakeInOrder(edge.storage, edge.maps, own.changes);
  edge.storage.obstacles.Merge({{*Wire(5, 47.0).obstacle}, {}, true});
  RemoveUntold(edge.storage, edge.maps, {{ChangeSubject::kMap, "told/1"}}, {7.0, 46.0, 9.0, 48.0});
  CHECK_FALSE(edge.storage.sites.Find("told-r1"));
  CHECK(edge.storage.maps.Find("told/1"));
  CHECK(edge.storage.sites.Find("own-r1"));
  CHECK_FALSE(edge.storage.obstacles.Find("wire"));
  // None of it is sent as a removal.
  CHECK(edge.storage.changes.ListUnknownAbove(10).size() == 2);
}

TEST_CASE("merging: a withdrawn obstacle comes back as it was") {
  Server edge;
  const ToldChange wire = Wire(5, 47.0);
  ToldChange left;
  left.change.key = wire.change.key;
  left.has_left = true;
  MergeFromAbove(edge.storage, edge.maps, {wire});
  MergeFromAbove(edge.storage, edge.maps, {left});
  CHECK_FALSE(edge.storage.obstacles.Find("wire"));
  CHECK(edge.storage.changes.ListUnknownAbove(10).empty());
  MergeFromAbove(edge.storage, edge.maps, {wire});
  CHECK(edge.storage.obstacles.Find("wire"));
}

TEST_CASE("merging: what another clock takes for expired stays until it is by the own one") {
  Server server;
  ToldChange wire = Wire(5, 47.0);
  wire.obstacle->expires_at_us = NowUs() + 60 * kMinute;
  MergeFromBelow(server.storage, server.maps, {wire});
  ToldChange expired = Removal(ChangeSubject::kObstacle, "wire", 5);
  expired.change.kind = ChangeKind::kExpired;
  MergeFromBelow(server.storage, server.maps, {expired});
  CHECK(server.storage.obstacles.Find("wire"));
  MergeFromAbove(server.storage, server.maps, {expired});
  CHECK(server.storage.obstacles.Find("wire"));
}

// Some bits of a deflated part do not change what it inflates to.
bool IsRefusedOrTheSameGround(const std::string& bytes, const TakenMap& expected) {
  const auto content = [](const std::string& tile) {
    return SerializeTile(DeserializeTile(tile, GridOf({0, 0, 0}, 1.0), TileLayers::kWithCues));
  };
  try {
    const TakenMap taken = ParseMapBytes(bytes, expected.map.id);
    return std::equal(taken.tiles.begin(),
                      taken.tiles.end(),
                      expected.tiles.begin(),
                      expected.tiles.end(),
                      [&](const auto& a, const auto& b) {
                        return a.first == b.first && content(a.second) == content(b.second);
                      });
  } catch (const ApiError&) {
    return true;
  }
}

TEST_CASE("maps as bytes: the same on both servers, and cut bytes and changed ground are refused") {
  const ToldFlight flight = Fly({.id = "a", .seen_at_us = kFirst});
  const std::string& bytes = flight.map_bytes.at("a/1");
  Server server;
  const TakenMap taken = ParseMapBytes(bytes, "a/1");
  CHECK(taken.tiles.size() > 4);
  server.storage.maps.Stage(taken.map, taken.tiles, {});
  CHECK(MapBytes(server.storage, taken.map) == bytes);
  CHECK_THROWS_AS(ParseMapBytes(bytes, "b/1"), ApiError);
  CHECK_THROWS_AS(ParseMapBytes("", "a/1"), ApiError);
  for (size_t i = 1; i < 40; ++i) {
    CHECK_THROWS_AS(ParseMapBytes(bytes.substr(0, bytes.size() * i / 40), "a/1"), ApiError);
    // The digest of all guards the lines before the tiles.
    const size_t tiles = bytes.find('\n', bytes.find('\n') + 1) + 1;
    std::string changed = bytes;
    changed[tiles + (bytes.size() - tiles) * i / 40] ^= 0x20;
    CHECK(IsRefusedOrTheSameGround(changed, taken));
  }
}

}  // namespace
}  // namespace freelsd
