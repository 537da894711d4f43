#include "server/recall/other_maps/other_maps.h"

#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include "server/recall/recall.h"
#include "tests/server/meadow_map.h"

namespace freelsd {
namespace {

constexpr int64_t kFirst = 1600000000000000;
constexpr float kUnseen = std::numeric_limits<float>::quiet_NaN();
constexpr float kWallM = 40.0f;

const GeoPoint kOrigin{47.0, 8.0, 400.0};
const AltitudeReference kAmsl{"amsl", 47.0, 8.0, "own"};

// Level ground at 0 but for a wall through the middle, in blocks of 2 m, about a place that lies
// so far east of the own origin and so far above it.
OtherGround WallAt(double east_m, double above_m, const AltitudeReference& reference) {
  auto terrain = std::make_shared<KeptTerrain>();
  terrain->origin = LocalFrame(kOrigin).GeoFromWorld({east_m, 0.0, above_m});
  terrain->grid.cell_size_m = 2.0;
  terrain->grid.num_rows = terrain->grid.num_cols = 200;
  terrain->grid.north_west_in_world = {-200.0, 200.0};
  terrain->upper = cv::Mat1f(200, 200, 0.0f);
  terrain->upper.col(100).setTo(kWallM);
  terrain->is_seen = cv::Mat1b(200, 200, uchar{1});
  terrain->position_sd_m = 1.0;
  return {terrain, reference};
}

// Ground of 200 m x 200 m, level at `height`, whose eastern half is unseen.
ElevationMap HalfSeen(float height) {
  ElevationMap map;
  map.grid.cell_size_m = 1.0;
  map.grid.num_rows = map.grid.num_cols = 200;
  map.grid.north_west_in_world = {-100.0, 100.0};
  map.elevation = cv::Mat1f(200, 200, height);
  map.elevation.colRange(100, 200).setTo(kUnseen);
  map.upper = map.elevation.clone();
  map.position_sd_m = 0.0;
  return map;
}

TEST_CASE("other maps: a wall that only another map saw stands in unseen ground, levelled") {
  const ElevationMap map = HalfSeen(3.0f);
  // The wall lies 50 m east of the middle of the own map.
  const std::vector<OtherGround> others{WallAt(50.0, 25.0, {"unknown", 47.0, 8.0, "other"})};
  const cv::Mat1f upper = WithGroundOfOthers(map, kOrigin, kAmsl, others, 3.0);
  // What was seen stays.
  CHECK(cv::countNonZero(upper.colRange(0, 100) != 3.0f) == 0);
  // Level with the ground that both saw: 3 m, whatever the altitudes say.
  CHECK(upper(50, 110) == doctest::Approx(3.0f));
  CHECK(upper(50, 151) == doctest::Approx(3.0f + kWallM));
  // Wider by three deviations of 1 m, within a block.
  for (const int col : {147, 155}) CHECK(upper(50, col) == doctest::Approx(3.0f + kWallM));
  for (const int col : {142, 160}) CHECK(upper(50, col) == doctest::Approx(3.0f));
}

TEST_CASE("other maps: without common ground the altitudes count, or nothing") {
  ElevationMap map = HalfSeen(3.0f);
  map.upper.setTo(kUnseen);
  const OtherGround known = WallAt(50.0, 25.0, {"amsl", 47.0, 8.0, "other"});
  const cv::Mat1f upper = WithGroundOfOthers(map, kOrigin, kAmsl, {known}, 3.0);
  CHECK(upper(50, 151) == doctest::Approx(kWallM + 25.0f + 3.0f).epsilon(1e-3));
  const OtherGround unknown = WallAt(50.0, 25.0, {"unknown", 47.0, 8.0, "other"});
  CHECK(std::isnan(WithGroundOfOthers(map, kOrigin, kAmsl, {unknown}, 3.0)(50, 151)));
}

TEST_CASE("other maps: a crop that the other map saw on most of the ground lowers no wall") {
  const ElevationMap map = HalfSeen(3.0f);
  for (const bool is_crop_theirs : {true, false}) {
    CAPTURE(is_crop_theirs);
    OtherGround other = WallAt(50.0, 0.0, {"unknown", 47.0, 8.0, "other"});
    const ElevationMap grown = HalfSeen(is_crop_theirs ? 3.0f : 5.5f);
    auto terrain = std::make_shared<KeptTerrain>(*other.terrain);
    // Maize stood on two thirds of the ground that both saw.
    if (is_crop_theirs)
      terrain->upper.rowRange(0, 130).setTo(2.5f, terrain->upper.rowRange(0, 130) == 0.0f);
    other.terrain = terrain;
    const cv::Mat1f upper = WithGroundOfOthers(grown, kOrigin, kAmsl, {other}, 3.0);
    CHECK(upper(50, 151) >= 3.0f + kWallM - 1e-3f);
  }
}

TEST_CASE("other maps: rough ground is levelled by the highest of a block on both maps") {
  ElevationMap map = HalfSeen(3.0f);
  cv::theRNG().state = 7;
  cv::Mat1f rough(200, 200);
  cv::randu(rough, 0.0f, 1.0f);
  map.upper += rough;
  OtherGround other = WallAt(0.0, 0.0, {"unknown", 47.0, 8.0, "other"});
  auto terrain = std::make_shared<KeptTerrain>(*other.terrain);
  // The same ground, in blocks of two cells.
  for (int row = 50; row < 150; ++row) {
    for (int col = 50; col < 100; ++col) {
      float& highest = terrain->upper(row, col);
      highest = -1e9f;
      for (int i = 0; i < 4; ++i) {
        highest = std::max(highest, rough(2 * (row - 50) + i / 2, 2 * (col - 50) + i % 2));
      }
    }
  }
  other.terrain = terrain;
  CHECK(WithGroundOfOthers(map, kOrigin, kAmsl, {other}, 3.0)(50, 101) >= 3.0f + kWallM);
}

SiteMap MeadowWithWallInTheNorth() {
  SiteMap meadow = Meadow();
  meadow.map.upper(cv::Rect(0, 266, 600, 4)).setTo(30.0f);
  return meadow;
}

TEST_CASE("other maps: a plan for another wind must hold on a later map, not on an earlier one") {
  for (const bool is_later : {true, false}) {
    CAPTURE(is_later);
    const TemporaryFolder folder;
    Storage storage(StorageAt(folder.path()));
    MapCache maps({size_t{1} << 26, size_t{1} << 22});
    const FlightMapRow map = StageMeadowMap(storage, Meadow(), "first", kFirst);
    const SiteRow site = SiteOnMap(map);
    storage.sites.PutEvaluation({{site}, {}, {map.id}, {}}, {});
    const Eigen::Vector2d to_north(0.0, 4.0), to_south(0.0, -4.0);
    const Aircraft aircraft = *AircraftProfile("small");
    const auto plan_for = [&](const Eigen::Vector2d& wind_in_world) {
      const auto kept = maps.Get(storage, site.id, site.updated_at_us);
      REQUIRE(kept);
      return *maps.PlanFor(storage, kept, aircraft, wind_in_world);
    };
    REQUIRE(plan_for(to_north).verdict != Verdict::kRejected);
    REQUIRE(plan_for(to_south).verdict != Verdict::kRejected);
    const FlightMapRow other = StageMeadowMap(
        storage, MeadowWithWallInTheNorth(), "other", is_later ? kFirst + 1 : kFirst - 1);
    EvaluationRows rows;
    rows.new_maps = {other.id};
    StoreEvaluation(storage, maps, *storage.sites.TakeTurn(), std::move(rows));
    // Into the wind: this final comes from the south, and the circle lies there.
    CHECK(plan_for(to_south).verdict != Verdict::kRejected);
    const Plan over_wall = plan_for(to_north);
    CHECK((over_wall.verdict == Verdict::kRejected) == is_later);
    if (is_later) {
      CHECK(over_wall.reject_detail.find("on the later map of other") == 0);
      ForgetFlight(storage, maps, "other");
      CHECK(plan_for(to_north).verdict != Verdict::kRejected);
    }
  }
}

// The site's own map got photographs of other ground later.
TEST_CASE("other maps: a later map counts although the own map is newer elsewhere") {
  const TemporaryFolder folder;
  Storage storage(StorageAt(folder.path()));
  MapCache maps({size_t{1} << 26, size_t{1} << 22});
  const FlightMapRow own = StageMeadowMap(storage, Meadow(), "first", kFirst + 10);
  SiteRow site = SiteOnMap(own);
  site.seen_at_us = kFirst;
  storage.sites.PutEvaluation({{site}, {}, {own.id}, {}}, {});
  const FlightMapRow other =
      StageMeadowMap(storage, MeadowWithWallInTheNorth(), "other", kFirst + 5);
  EvaluationRows rows;
  rows.new_maps = {other.id};
  StoreEvaluation(storage, maps, *storage.sites.TakeTurn(), std::move(rows));
  const auto kept = maps.Get(storage, site.id, site.updated_at_us);
  REQUIRE(kept);
  const Aircraft aircraft = *AircraftProfile("small");
  CHECK(maps.PlanFor(storage, kept, aircraft, Eigen::Vector2d(0.0, 4.0))->verdict ==
        Verdict::kRejected);
  CHECK(maps.PlanFor(storage, kept, aircraft, Eigen::Vector2d(0.0, -4.0))->verdict !=
        Verdict::kRejected);
}

// Only the ground below the northern final and circle, with the wall.
SiteMap WallAlone() {
  SiteMap wall = MeadowWithWallInTheNorth();
  for (cv::Mat1f* const layer :
       {&wall.map.elevation, &wall.map.upper, &wall.map.standard_deviation}) {
    layer->rowRange(275, 600).setTo(kUnseen);
  }
  return wall;
}

TEST_CASE("other maps: every answer about a place counts a later map without its touchdown") {
  const MeadowServer meadow([](Storage& storage) {
    const FlightMapRow own = StageMeadowMap(storage, Meadow(), "f", kFirst);
    const FlightMapRow other = StageMeadowMap(storage, WallAlone(), "other", kFirst + 1);
    storage.sites.PutEvaluation({{SiteOnMap(own)}, {}, {own.id}, {}}, {});
    storage.sites.PutEvaluation({{}, {}, {other.id}, {}}, {});
  });
  const std::string site = "/v1/sites/f-r1/";
  const nlohmann::json rose = GetJson(*meadow.client, site + "wind-rose?directions=2&speeds_mps=4");
  CAPTURE(rose.dump());
  const std::string place = "latitude_deg=47&longitude_deg=8&";
  // From the north, then from the south.
  for (const size_t from : {size_t{0}, size_t{1}}) {
    CAPTURE(from);
    const std::string wind =
        "wind_east_mps=0&wind_north_mps=" + std::string(from == 0 ? "-4" : "4");
    const bool is_refused = from == 1;
    CHECK((rose["entries"][from]["verdict"] == "rejected") == is_refused);
    CHECK((GetJson(*meadow.client, site + "approach?" + wind)["plan"]["verdict"] == "rejected") ==
          is_refused);
    for (const std::string& why :
         {site + "why?" + place + wind, "/v1/flights/f/why?" + place + wind}) {
      const nlohmann::json answer = GetJson(*meadow.client, why);
      CAPTURE(answer.dump());
      CHECK((answer["verdict"] == "rejected") == is_refused);
      CHECK((answer["first_failed"] == "surroundings") == is_refused);
    }
  }
}

}  // namespace
}  // namespace freelsd
