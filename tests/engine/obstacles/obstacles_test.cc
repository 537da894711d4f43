#include "engine/obstacles/obstacles.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <doctest/doctest.h>

#include "tests/engine/approach/scene.h"
#include "tests/engine/refusal.h"

namespace freelsd {
namespace {

using scene::AddUnseen;
using scene::Box;
using scene::FlatMeadow;
using scene::Nimble;
using scene::OneWay;
using scene::Request;
using scene::Scene;

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
const Eigen::Vector2d kNorthWind(0.0, -4.0);

HardObstacle Wire(const Eigen::Vector3d& from,
                  const Eigen::Vector3d& to,
                  std::optional<double> height = std::nullopt,
                  double position_sd_m = 0.0) {
  return {"wire", HardObstacle::Shape::kLine, {from, to}, height, position_sd_m};
}

HardObstacle Mast(const Eigen::Vector3d& top, std::optional<double> height = std::nullopt) {
  return {"mast", HardObstacle::Shape::kLine, {top}, height, 0.0};
}

// As the service plans: hazards for the aircraft on the map with the obstacles.
Plan PlanAmong(const Scene& on,
               const std::vector<HardObstacle>& obstacles,
               const ApproachOptions& options = OneWay()) {
  const Aircraft aircraft = Nimble();
  const PlannableGround ground(on.map, on.hazards, obstacles, aircraft, HazardOptions{});
  return ground.PlanFor(Request(Box({-5, -5}, {5, 5}), kNorthWind), aircraft, {options, 400.0});
}

TEST_CASE("obstacles: a wire raises the cells within its deviation and half a cell, no others") {
  const Scene meadow = FlatMeadow(100, 100);
  const HardObstacle wire = Wire({-200, 0.5, 20}, {200, 0.5, 20}, std::nullopt, 2.0);
  const AssessedMap ground = WithObstacles(meadow.map, meadow.hazards, {wire}, {});
  for (int row = 0; row < 100; ++row) {
    const double distance = std::abs(meadow.CellCenter(row, 50).y() - 0.5);
    const bool is_wire = distance <= 2.0 * 2.0 + std::sqrt(0.5);
    CAPTURE(distance);
    CHECK(ground.map.upper(row, 50) == (is_wire ? 20.0f : 0.0f));
    CHECK(ground.layers.grass(row, 50) == (is_wire ? 0.0f : 1.0f));
    CHECK(ground.map.elevation(row, 50) == 0.0f);
  }
  // The input keeps its rasters.
  CHECK(meadow.map.upper(50, 50) == 0.0f);
  CHECK(meadow.hazards.grass(50, 50) == 1.0f);
}

TEST_CASE("obstacles: the top follows a wire that climbs, and a height above ground the ground") {
  const Scene slope =
      scene::Meadow(100, 100, 1.0, [](const Eigen::Vector2d& place) { return 0.1 * place.x(); });
  const AssessedMap climbing =
      WithObstacles(slope.map, slope.hazards, {Wire({-50, 0.5, 10}, {50, 0.5, 60})}, {});
  CHECK(climbing.map.upper(49, 50) == doctest::Approx(10.0 + 0.5 * 50.5).epsilon(0.01));
  const AssessedMap hung = WithObstacles(
      slope.map, slope.hazards, {Wire({-50, 0.5, kUnknown}, {50, 0.5, kUnknown}, 12.0)}, {});
  CHECK(hung.map.upper(49, 20) == doctest::Approx(slope.map.elevation(49, 20) + 12.0));
  CHECK(hung.map.upper(49, 80) == doctest::Approx(slope.map.elevation(49, 80) + 12.0));
}

TEST_CASE("obstacles: a top that seems to lie in the ground counts as low above it") {
  const Scene meadow = FlatMeadow(100, 100);
  const ObstacleOptions options;
  const AssessedMap ground =
      WithObstacles(meadow.map, meadow.hazards, {Wire({-200, 0.5, -15}, {200, 0.5, -15})}, options);
  CHECK(ground.map.upper(49, 50) == options.min_height_m);
}

TEST_CASE("obstacles: unseen cells get the top over the nearest known ground and stay unseen") {
  Scene meadow = FlatMeadow(100, 100);
  meadow.map.elevation += 5.0f;
  AddUnseen(meadow, {-50, -20}, {50, 20});
  const HardObstacle wire = Wire({-200, 0.5, kUnknown}, {200, 0.5, kUnknown}, 12.0);
  const AssessedMap ground = WithObstacles(meadow.map, meadow.hazards, {wire}, {});
  CHECK(ground.map.upper(49, 50) == 17.0f);
  CHECK_FALSE(ground.map.IsSeen(49, 50));
  const HazardLayers layers = WithLimits(ground.map, ground.layers, {8.0, 0.5}, {});
  CHECK(layers.hazard(49, 50) == kUnseen);
}

TEST_CASE("obstacles: their seen cells are hazards for any limits of the aircraft") {
  const Scene meadow = FlatMeadow(100, 100);
  const HardObstacle low = Wire({-200, 0.5, kUnknown}, {200, 0.5, kUnknown}, 0.3);
  const AssessedMap ground = WithObstacles(meadow.map, meadow.hazards, {low}, {});
  const HazardLayers layers = WithLimits(ground.map, ground.layers, {80.0, 900.0}, {});
  CHECK(layers.hazard(49, 50) == kHazard);
  CHECK(layers.hazard(40, 50) == kFree);
  CHECK(layers.distance(40, 50) < meadow.hazards.distance(40, 50));
}

TEST_CASE("obstacles: a wire across the final blocks it, low or high above the path") {
  const Scene meadow = FlatMeadow(240, 240);
  REQUIRE(PlanAmong(meadow, {}).verdict == Verdict::kLandable);
  const double distance = ApproachDistance(Nimble(), 4.0);
  // The path is 5 m high there. One wire is above it: nobody flies below a wire.
  for (const double top : {6.0, 40.0}) {
    CAPTURE(top);
    const double south = -0.5 * distance;
    const Plan plan = PlanAmong(meadow, {Wire({-300, south, top}, {300, south, top})});
    CHECK(plan.verdict == Verdict::kRejected);
    CHECK(plan.reject_reason == RejectReason::kApproachBlocked);
  }
}

TEST_CASE("obstacles: a wire far below the path and beside all ways blocks nothing") {
  const Scene meadow = FlatMeadow(240, 240);
  const Plan aside = PlanAmong(meadow, {Wire({-300, 60, 20}, {300, 60, 20})});
  CHECK(aside.verdict == Verdict::kLandable);
}

TEST_CASE("obstacles: a mast in one circle leaves the other, masts in both block") {
  const Scene meadow = FlatMeadow(240, 240);
  const Plan free = PlanAmong(meadow, {});
  REQUIRE(free.approach);
  const double radius = free.approach->loiter_radius;
  const Eigen::Vector2d start = free.approach->approach_start_in_world.head<2>();
  const HardObstacle west = Mast({start.x() - 2.0 * radius, start.y(), 30.0});
  const HardObstacle east = Mast({start.x() + 2.0 * radius, start.y(), 30.0});
  CHECK(PlanAmong(meadow, {west}).verdict == Verdict::kLandable);
  CHECK(PlanAmong(meadow, {east}).verdict == Verdict::kLandable);
  HardObstacle wide_west = west, wide_east = east;
  wide_west.position_sd_m = wide_east.position_sd_m = 5.0;
  const Plan both = PlanAmong(meadow, {wide_west, wide_east});
  CHECK(both.verdict == Verdict::kRejected);
  CHECK(both.reject_reason == RejectReason::kLoiterBlocked);
}

TEST_CASE("obstacles: nobody lands among people, nor passes low over them") {
  const Scene meadow = FlatMeadow(240, 240);
  const double people_height = ObstacleOptions{}.people_height_m;
  const auto people = [&](double half, double north) {
    HardObstacle made{"people", HardObstacle::Shape::kArea, {}, people_height, 0.0};
    made.points_in_world = {{-half, north - half, kUnknown},
                            {half, north - half, kUnknown},
                            {half, north + half, kUnknown},
                            {-half, north + half, kUnknown}};
    return made;
  };
  const Plan among = PlanAmong(meadow, {people(3.0, 0.0)});
  CHECK(among.verdict == Verdict::kRejected);
  CHECK(among.reject_reason == RejectReason::kNoSafeTouchdown);
  CHECK(PlanAmong(meadow, {people(40.0, 0.0)}).verdict == Verdict::kRejected);
  CHECK(PlanAmong(meadow, {people(8.0, -32.0)}).reject_reason == RejectReason::kApproachBlocked);
}

TEST_CASE("obstacles: a circle that reaches beyond the map meets an obstacle there") {
  // The final lies on the map, the circles reach beyond its southern edge.
  const Scene meadow = FlatMeadow(116, 240);
  ApproachOptions options = OneWay();
  const Plan free = PlanAmong(meadow, {}, options);
  REQUIRE(free.verdict == Verdict::kUnverified);
  REQUIRE(free.approach);
  const Eigen::Vector3d& center = free.approach->loiter_center_in_world;
  const double south = center.y() - free.approach->loiter_radius;
  REQUIRE(south < -60.0);
  const HardObstacle mast = Mast({center.x(), south, kUnknown}, 12.0);
  CHECK(PlanAmong(meadow, {mast}, options).verdict == Verdict::kRejected);
  const HardObstacle low = Mast({center.x(), south, kUnknown}, 1.0);
  CHECK(PlanAmong(meadow, {low}, options).verdict == Verdict::kUnverified);
  const HardObstacle far = Mast({center.x(), south - 60.0, kUnknown}, 12.0);
  CHECK(PlanAmong(meadow, {far}, options).verdict == Verdict::kUnverified);
}

TEST_CASE("obstacles: the plan without them is kept where they alone reject a region") {
  const Scene meadow = FlatMeadow(240, 240);
  const Aircraft aircraft = Nimble();
  const PlanRequest request = Request(Box({-5, -5}, {5, 5}), kNorthWind);
  const std::vector<HardObstacle> on_field{Mast({0, 0, 30.0})};
  const PlannableGround ground(meadow.map, meadow.hazards, on_field, aircraft, HazardOptions{});
  CHECK(ground.PlanFor(request, aircraft, {OneWay(), 400.0}).verdict == Verdict::kRejected);
  const auto without = ground.PlanWithoutObstacles(request, aircraft, {OneWay(), 400.0});
  REQUIRE(without);
  CHECK(without->verdict == Verdict::kLandable);
  const std::vector<HardObstacle> none;
  const PlannableGround bare(meadow.map, meadow.hazards, none, aircraft, HazardOptions{});
  CHECK_FALSE(bare.PlanWithoutObstacles(request, aircraft, {OneWay(), 400.0}));
}

TEST_CASE("obstacles: options and grids are checked") {
  const Scene meadow = FlatMeadow(10, 10), other = FlatMeadow(11, 10);
  CHECK_THROWS_AS(WithObstacles(meadow.map, other.hazards, {}, {}), std::invalid_argument);
  CHECK(IsRefused(&ObstacleOptions::position_sigma, -1.0, "obstacles.position_sigma"));
  CHECK(IsRefused(&ObstacleOptions::min_height_m, 0.0, "obstacles.min_height_m"));
  CHECK(IsRefused(&ObstacleOptions::people_height_m, 0.0, "obstacles.people_height_m"));
}

}  // namespace
}  // namespace freelsd
