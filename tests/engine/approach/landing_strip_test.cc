#include "engine/approach/landing_strip.h"

#include <random>

#include <doctest/doctest.h>

#include "tests/engine/approach/scene.h"

namespace freelsd {
namespace {

using scene::Nimble;
using scene::Scene;

constexpr double kMaxLossM = 2.0;  // of a cell of 1 m, at each end of the strip

Aircraft Narrow() {
  Aircraft aircraft = Nimble();
  aircraft.path_half_width_m = 5.0;
  return aircraft;
}

// The strip as an area of places: the middle of the corner places, by metres along and to the
// right.
bool IsAllFree(const Scene& scene,
               const Eigen::Vector2d& touchdown,
               double heading,
               const LandingStrip& strip) {
  const Eigen::Vector2d forward = DirectionOf(heading), right(forward.y(), -forward.x());
  for (double along = -strip.behind; along <= strip.ahead; along += 0.2) {
    for (double across = -strip.left; across <= strip.right; across += 0.2) {
      const auto cell = scene.map.grid.CellAt(touchdown + along * forward + across * right);
      if (!cell || scene.hazards.hazard(*cell) != kFree) return false;
    }
  }
  return true;
}

TEST_CASE("strip: a free lane of 180 m by 35 m is measured, never as more") {
  Scene scene = scene::FlatMeadow(400, 200);
  scene.hazards.hazard = uchar{kHazard};
  scene::ForCells(scene, {-15, -60}, {20, 120}, [&](int row, int col) {
    scene.hazards.hazard(row, col) = kFree;
  });
  const LandingStrip strip = MeasureStrip({0, 0, 0}, 0.0, scene.hazards, Narrow());
  CHECK(strip.ahead <= 120.0);
  CHECK(strip.ahead > 120.0 - kMaxLossM);
  CHECK(strip.behind <= 60.0);
  CHECK(strip.behind > 60.0 - kMaxLossM);
  CHECK(strip.left <= 15.0);
  CHECK(strip.left > 15.0 - kMaxLossM);
  CHECK(strip.right <= 20.0);
  CHECK(strip.right > 20.0 - kMaxLossM);
  // Across the lane it is short; a corridor of 10 m fits.
  const LandingStrip across = MeasureStrip({0, 0, 0}, kPi / 2.0, scene.hazards, Narrow());
  CHECK(across.Length() <= 35.0);
  CHECK(across.Width() <= 180.0);
  CHECK(across.Width() > 180.0 - 2.0 * kMaxLossM);
}

TEST_CASE("strip: no part of it is hazard or unseen, on any heading") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-60.0, 60.0), heading(0.0, 2.0 * kPi);
  int num_long = 0;
  for (int trial = 0; trial < 200; ++trial) {
    Scene scene = scene::FlatMeadow(120, 120);
    for (int i = 0; i < 25; ++i) {
      const auto cell = scene.map.grid.CellAt({place(random), place(random)});
      if (cell) scene.hazards.hazard(*cell) = i % 2 == 0 ? kHazard : kUnseen;
    }
    const auto near = scene.map.grid.CellAt({place(random) / 3.0, place(random) / 3.0});
    const Eigen::Vector2d touchdown = scene.CellCenter(near->y, near->x);
    const double along = heading(random);
    const LandingStrip strip =
        MeasureStrip({touchdown.x(), touchdown.y(), 0.0}, along, scene.hazards, Narrow());
    CAPTURE(trial);
    REQUIRE(strip.ahead >= 0.0);
    REQUIRE((strip.Length() == 0.0 || strip.Width() >= 2.0 * Narrow().path_half_width_m - 1e-9));
    if (strip.Length() > 0.0) REQUIRE(IsAllFree(scene, touchdown, along, strip));
    num_long += strip.Length() > 20.0;
  }
  CHECK(num_long > 50);
}

TEST_CASE("strip: a touchdown on a hazard, or at the map's edge, has none") {
  Scene scene = scene::FlatMeadow(100, 100);
  CHECK(MeasureStrip({0, 49.5, 0}, 0.0, scene.hazards, Narrow()).Length() == 0.0);
  scene::AddBlock(scene, {0, 0}, {1, 1}, 2.0);
  const LandingStrip strip = MeasureStrip({0.5, 0.5, 0}, 0.0, scene.hazards, Narrow());
  CHECK(strip.Length() == 0.0);
  CHECK(strip.Width() == 0.0);
}

TEST_CASE("strip: an accepted plan's strip is longer than its ground roll, which it draws") {
  const Scene scene = scene::FlatMeadow(200, 200, 2.0);
  const Aircraft aircraft = Nimble();
  const Plan plan = scene::PlanOn(
      scene, scene::Request(scene::Box({-20, -20}, {20, 20}), Eigen::Vector2d(0, -4)));
  REQUIRE(plan.verdict == Verdict::kLandable);
  const Approach& approach = *plan.approach;
  REQUIRE(approach.ground_roll_in_world.size() == 4);
  const auto& corners = approach.ground_roll_in_world;
  const double length = (corners[1] - corners[0]).norm(), width = (corners[2] - corners[1]).norm();
  CHECK(length == doctest::Approx(aircraft.ground_roll_m + 3.0));  // three deviations of 1 m
  CHECK(width == doctest::Approx(2.0 * (aircraft.path_half_width_m + 3.0)));
  CHECK(approach.strip->ahead >= length);
  CHECK(approach.strip->Width() >= width);
  // The roll lies ahead, on both sides of the heading.
  const Eigen::Vector3d far_end = 0.5 * (corners[1] + corners[2]);
  CHECK((far_end - approach.touchdown_in_world).head<2>().dot(DirectionOf(approach.heading)) ==
        doctest::Approx(length));
}

TEST_CASE("obstacle: the end of a final over a free meadow is no obstacle") {
  Scene scene = scene::FlatMeadow(200, 200, 2.0);
  const PlanRequest request = scene::Request(scene::Box({-2, 58}, {2, 62}), Eigen::Vector2d(0, -4));
  const Plan clear = scene::PlanOn(scene, request);
  REQUIRE(clear.verdict == Verdict::kLandable);
  CHECK(clear.approach->min_clearance < Nimble().safety_margin_m);  // the flare
  CHECK_FALSE(clear.approach->obstacle);
  // A track without grass is no obstacle either.
  scene::AddBlock(scene, {-10, 28}, {10, 30}, 0.1);
  const Plan over_track = scene::PlanOn(scene, request);
  REQUIRE(over_track.verdict == Verdict::kLandable);
  CHECK_FALSE(over_track.approach->obstacle);
  // A hedge of 2 m, 40 m before the touchdown.
  scene::AddBlock(scene, {-10, 18}, {10, 20}, 2.0);
  const Plan above = scene::PlanOn(scene, request);
  REQUIRE(above.verdict == Verdict::kLandable);
  const PathObstacle obstacle = above.approach->obstacle.value();
  CHECK(obstacle.part == PathPart::kFinal);
  CHECK(obstacle.place_in_world.z() == doctest::Approx(2.0));
  CHECK(std::abs(obstacle.distance - 40.0) < 4.0);
  const double path =
      obstacle.distance * above.approach->approach_height / above.approach->approach_distance;
  CHECK(obstacle.clearance == doctest::Approx(path - 2.0));
  CHECK(obstacle.clearance >= obstacle.wanted);
}

TEST_CASE("obstacle: below the circle it is found too, also free ground that rises") {
  const PlanRequest request = scene::Request(scene::Box({-2, 58}, {2, 62}), Eigen::Vector2d(0, -4));
  // West of x = -30 the meadow rises to 4 m: only the circle is there.
  const Scene rising = scene::Meadow(
      200, 200, 2.0, [](const Eigen::Vector2d& place) { return place.x() < -30.0 ? 4.0 : 0.0; });
  const Scene both = scene::Meadow(200, 200, 2.0, [](const Eigen::Vector2d& place) {
    return std::abs(place.x()) > 30.0 ? 4.0 : 0.0;
  });
  CHECK_FALSE(scene::PlanOn(rising, request).approach->obstacle);  // it turns right, over the plain
  const Plan plan = scene::PlanOn(both, request);
  REQUIRE(plan.verdict == Verdict::kLandable);
  REQUIRE(plan.approach->obstacle);
  CHECK(plan.approach->obstacle->part == PathPart::kCircle);
  CHECK(plan.approach->obstacle->clearance ==
        doctest::Approx(plan.approach->approach_height - 4.0));
}

}  // namespace
}  // namespace freelsd
