// Later maps of flights and the sites that they supersede.
#include <latch>
#include <thread>

#include <doctest/doctest.h>

#include "server/recall/recall.h"
#include "tests/server/meadow_map.h"
#include "tests/storage/place.h"

namespace freelsd {
namespace {

constexpr int64_t kFirst = 1600000000000000;
constexpr int64_t kLater = kFirst + 1000000;

SiteMap MeadowWithWall() {
  SiteMap meadow = Meadow();
  // Across every final from the south.
  meadow.map.upper(cv::Rect(0, 330, 600, 4)).setTo(30.0f);
  return meadow;
}

// A stored plan that lands to the north over the southern part of the meadow.
SiteRow PlannedSite(Storage& storage,
                    MapCache& maps,
                    const FlightMapRow& map,
                    double longitude_deg) {
  SiteRow site = SiteOnMap(map, longitude_deg);
  site.id = map.flight_id + "-r1";
  Replan replan = ParseReplan(site.replan_json);
  replan.request.wind_in_world = Eigen::Vector2d(0.0, -4.0);
  site.replan_json = ReplanJson(replan);
  storage.sites.PutEvaluation({{site}, {}, {map.id}, {}}, {});
  const auto kept = maps.Get(storage, site.id, site.updated_at_us);
  REQUIRE(kept);
  // As an evaluation does, which knows no other flights.
  const auto on_map = maps.PlannerFor(kept, replan.flight.aircraft);
  const Plan plan = on_map->planner.PlanFor(replan.request.wind_in_world);
  REQUIRE(plan.approach);
  const FlightContext context{map.flight_id, "amsl", LocalFrame(replan.origin)};
  Site evaluated;
  evaluated.plan = plan;
  site.approach_json = ApproachJson(plan, context).dump();
  site.feature_json =
      SiteFeature(site.id, evaluated, replan.flight.aircraft, "2020-01-01T00:00:00Z", context)
          .dump();
  const GeoPoint touchdown = context.local_frame.GeoFromWorld(plan.touchdown_in_world);
  site.latitude_deg = touchdown.latitude_deg;
  site.longitude_deg = touchdown.longitude_deg;
  site.updated_at_us = 7;
  return site;
}

struct Memory {
  TemporaryFolder folder;
  Storage storage{StorageAt(folder.path())};
  MapCache maps{{size_t{1} << 26, size_t{1} << 22}};

  void Evaluate(const std::string& flight_id,
                const SiteMap& ground,
                int64_t seen_at_us,
                double longitude_deg = 8.0) {
    const FlightMapRow map =
        StageMeadowMap(storage, ground, flight_id, seen_at_us, std::nullopt, longitude_deg);
    EvaluationRows rows;
    rows.new_maps = {map.id};
    StoreEvaluation(storage, maps, *storage.sites.TakeTurn(), std::move(rows));
  }
  void EvaluateFirst(double longitude_deg = 8.0) {
    const FlightMapRow map =
        StageMeadowMap(storage, Meadow(), "first", kFirst, std::nullopt, longitude_deg);
    EvaluationRows rows;
    rows.sites = {PlannedSite(storage, maps, map, longitude_deg)};
    rows.new_maps = {map.id};
    StoreEvaluation(storage, maps, *storage.sites.TakeTurn(), std::move(rows));
  }
  SiteRow First() const { return *storage.sites.Find("first-r1"); }
};

TEST_CASE(
    "memory of maps: a later map with a wall supersedes, and no longer when it is forgotten") {
  Memory memory;
  memory.EvaluateFirst();
  memory.Evaluate("later", MeadowWithWall(), kLater);
  CHECK(memory.First().superseded_by == "later");
  CHECK(memory.First().superseded_by_map == "later/1");
  CHECK_FALSE(memory.First().superseded_reason.empty());
  CHECK(memory.storage.sites.ListRecallable({7.9, 46.9, 8.1, 47.1}).empty());
  // Its own newer evaluation shows free ground again.
  const FlightMapRow free = StageMeadowMap(memory.storage, Meadow(), "later", kLater);
  EvaluationRows rows;
  rows.new_maps = {free.id};
  rows.forgotten_maps = {"later/1"};
  StoreEvaluation(memory.storage, memory.maps, *memory.storage.sites.TakeTurn(), std::move(rows));
  CHECK_FALSE(memory.First().superseded_by);
  memory.Evaluate("latest", MeadowWithWall(), kLater + 1);
  CHECK(memory.First().superseded_by == "latest");
  ForgetFlight(memory.storage, memory.maps, "latest");
  CHECK_FALSE(memory.First().superseded_by);
  CHECK(memory.storage.maps.ListOf("latest").empty());
}

TEST_CASE(
    "memory of maps: an earlier or simultaneous map changes nothing, in any order of arrival") {
  for (const bool is_first_last : {false, true}) {
    Memory memory;
    if (!is_first_last) memory.EvaluateFirst();
    memory.Evaluate("earlier", MeadowWithWall(), kFirst - 1);
    memory.Evaluate("same", MeadowWithWall(), kFirst);
    if (is_first_last) memory.EvaluateFirst();
    CHECK_FALSE(memory.First().superseded_by);
    CHECK_FALSE(memory.First().confirmed_at_us);
  }
}

TEST_CASE(
    "memory of maps: at the antimeridian, a later map is found at its ground and supersedes") {
  // The origins lie on both sides, 15 m from each other.
  for (const double first_deg : {179.9999, -179.9999}) {
    CAPTURE(first_deg);
    Memory memory;
    memory.EvaluateFirst(first_deg);
    memory.Evaluate("later", MeadowWithWall(), kLater, -first_deg);
    const SiteStore& sites = memory.storage.sites;
    for (const double longitude_deg : {179.999, 179.9999, 180.0, -180.0, -179.9999, -179.999}) {
      CAPTURE(longitude_deg);
      CHECK(sites.ListMaps(BoxAroundPlace({47.0, longitude_deg, 0.0}, 0.0)).size() == 2);
      CHECK(sites.ListMaps(BoxAroundPlace({47.0, longitude_deg, 0.0}, 500.0)).size() == 2);
    }
    for (const double longitude_deg : {0.0, 90.0, 179.9, -179.9}) {
      CAPTURE(longitude_deg);
      CHECK(sites.ListMaps(BoxAroundPlace({47.0, longitude_deg, 0.0}, 500.0)).empty());
    }
    CHECK(memory.First().superseded_by == "later");
    const SiteRow first = memory.First();
    const auto kept = memory.maps.Get(memory.storage, first.id, first.updated_at_us);
    REQUIRE(kept);
    REQUIRE(kept->other_maps.size() == 1);
    CHECK(kept->other_maps[0]->id == "later/1");
  }
}

// One of several processes on a database.
struct Process {
  Storage storage;
  MapCache maps{{size_t{1} << 26, size_t{1} << 22}};

  void Store(EvaluationRows rows) {
    const std::unique_ptr<SiteTurn> turn = storage.sites.TakeTurn();
    StoreEvaluation(storage, maps, *turn, std::move(rows));
  }
};

TEST_SUITE("postgresql" * doctest::skip()) {
  TEST_CASE("memory of maps: results that two processes store at the same time see each other") {
    constexpr int kNumTimes = 20;
    Memory planned;
    const SiteRow site =
        PlannedSite(planned.storage,
                    planned.maps,
                    StageMeadowMap(planned.storage, Meadow(), "first", kFirst, std::nullopt, 8.0),
                    8.0);
    for (int i = 0; i < kNumTimes; ++i) {
      const StoragePlace place;
      Process one{Storage(place.OptionsOfOne())};
      Process other{Storage(place.OptionsOfOther())};
      EvaluationRows first;
      first.sites = {site};
      first.new_maps = {
          StageMeadowMap(one.storage, Meadow(), "first", kFirst, std::nullopt, 8.0).id};
      REQUIRE(first.new_maps[0] == site.map_id);
      EvaluationRows later;
      later.new_maps = {
          StageMeadowMap(other.storage, MeadowWithWall(), "later", kLater, std::nullopt, 8.0).id};
      std::latch begin(2);
      std::thread of_one([&] {
        begin.arrive_and_wait();
        one.Store(first);
      });
      std::thread of_other([&] {
        begin.arrive_and_wait();
        other.Store(later);
      });
      of_one.join();
      of_other.join();
      CHECK(one.storage.sites.Find(site.id)->superseded_by == "later");
    }
  }
}

}  // namespace
}  // namespace freelsd
