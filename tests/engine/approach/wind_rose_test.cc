#include <cmath>
#include <limits>
#include <stdexcept>

#include <doctest/doctest.h>

#include "tests/engine/approach/scene.h"

namespace freelsd {
namespace {

using scene::AddBlock;
using scene::AddUnseen;
using scene::Box;
using scene::FlatMeadow;
using scene::Nimble;
using scene::Request;
using scene::Scene;

constexpr double kNoDifference = 1e-12;

// Blocks and gaps around a field, so that every verdict occurs.
Scene Obstructed() {
  Scene meadow = FlatMeadow(200, 220);
  AddBlock(meadow, {-60, 30}, {-40, 60}, 9.0);
  AddBlock(meadow, {20, -70}, {60, -62}, 14.0);
  AddBlock(meadow, {70, 10}, {74, 14}, 30.0);
  AddUnseen(meadow, {-30, -90}, {10, -70});
  return meadow;
}

PlanRequest InWind(const std::optional<Eigen::Vector2d>& wind) {
  return Request(Box({-40, -40}, {40, 40}), wind);
}

WindRose RoseOn(const Scene& on, const WindRoseOptions& rose_options) {
  const ApproachPlanner planner(
      on.map, on.hazards, InWind(std::nullopt), Nimble(), ApproachOptions{});
  return PlanWindRose(planner, rose_options);
}

TEST_CASE("approach planner: one wind after another as each by itself") {
  const Scene meadow = Obstructed();
  const PlanRequest request = Request(Box({-40, -40}, {40, 40}), std::nullopt);
  const ApproachPlanner planner(meadow.map, meadow.hazards, request, Nimble(), ApproachOptions{});
  int num_by_verdict[3] = {};
  const auto check = [&](const std::optional<Eigen::Vector2d>& wind) {
    PlanRequest in_wind = request;
    in_wind.wind_in_world = wind;
    const Plan alone =
        PlanApproach(meadow.map, meadow.hazards, in_wind, Nimble(), ApproachOptions{});
    const Plan plan = planner.PlanFor(wind);
    ++num_by_verdict[static_cast<int>(plan.verdict)];
    CHECK(plan.verdict == alone.verdict);
    CHECK(plan.reject_detail == alone.reject_detail);
    CHECK(plan.touchdown_in_world == alone.touchdown_in_world);
    CHECK(plan.score == alone.score);
    CHECK(plan.rejections.size() == alone.rejections.size());
    REQUIRE(plan.approach.has_value() == alone.approach.has_value());
    if (!plan.approach) return;
    CHECK(plan.approach->min_clearance == alone.approach->min_clearance);
    CHECK(plan.approach->unseen_ratio == alone.approach->unseen_ratio);
    CHECK(plan.approach->heading == alone.approach->heading);
  };
  check(std::nullopt);
  for (const double speed : {0.5, 3.0, 6.5, 40.0}) {
    for (int i = 0; i < 12; ++i) check(speed * DirectionOf(2.0 * kPi * i / 12));
  }
  CHECK(num_by_verdict[static_cast<int>(Verdict::kRejected)] > 0);
  CHECK(num_by_verdict[static_cast<int>(Verdict::kRejected)] < 49);
}

TEST_CASE("wind rose: each of its plans is what is planned for that wind alone") {
  const Scene meadow = Obstructed();
  const WindRose rose =
      RoseOn(meadow, {.num_directions = 24, .speeds_mps = {0.0, 0.4, 1.0, 3.0, 6.5, 40.0}});
  REQUIRE(rose.plans.size() == 24 * 6);
  int num_by_verdict[3] = {};
  for (size_t speed = 0; speed < rose.speeds.size(); ++speed) {
    for (size_t direction = 0; direction < 24; ++direction) {
      CAPTURE(speed);
      CAPTURE(direction);
      const Plan alone = PlanApproach(meadow.map,
                                      meadow.hazards,
                                      InWind(rose.WindInWorld(speed, direction)),
                                      Nimble(),
                                      ApproachOptions{});
      const Plan& plan = rose.At(speed, direction);
      ++num_by_verdict[static_cast<int>(plan.verdict)];
      CHECK(plan.verdict == alone.verdict);
      CHECK(plan.reject_reason == alone.reject_reason);
      CHECK(plan.reject_detail == alone.reject_detail);
      CHECK(plan.touchdown_in_world == alone.touchdown_in_world);
      CHECK(plan.hazard_distance == alone.hazard_distance);
      CHECK(plan.rejections.empty());
      REQUIRE(plan.approach.has_value() == alone.approach.has_value());
      if (!plan.approach) continue;
      CHECK(plan.approach->min_clearance == alone.approach->min_clearance);
      CHECK(plan.approach->unseen_ratio == alone.approach->unseen_ratio);
      CHECK(plan.approach->approach_height == alone.approach->approach_height);
      CHECK(plan.approach->crosswind == alone.approach->crosswind);
      CHECK(plan.approach->heading == alone.approach->heading);
      CHECK(plan.approach->loiter_direction == alone.approach->loiter_direction);
      CHECK(plan.approach->profile.distance.empty());
    }
  }
  CHECK(num_by_verdict[static_cast<int>(Verdict::kLandable)] > 0);
  CHECK(num_by_verdict[static_cast<int>(Verdict::kRejected)] > 0);
}

TEST_CASE("wind rose: its second of four winds comes from the east, and one lands towards it") {
  const WindRose rose = RoseOn(FlatMeadow(120, 120), {.num_directions = 4, .speeds_mps = {4.0}});
  CHECK((rose.WindInWorld(0, 1) - Eigen::Vector2d(-4.0, 0.0)).norm() < kNoDifference);
  const Plan& plan = rose.At(0, 1);
  CHECK(plan.verdict == Verdict::kLandable);
  REQUIRE(plan.approach);
  CHECK(WrapAngle(plan.approach->heading - RadFromDeg(90.0)) ==
        doctest::Approx(0.0).epsilon(kNoDifference));
  CHECK(plan.approach->approach_start_in_world.x() < plan.touchdown_in_world.x());
}

TEST_CASE("wind rose: a region that is refused is refused in every wind, and too strong is said") {
  const Scene meadow = FlatMeadow(120, 120);
  PlanRequest request = InWind(std::nullopt);
  request.area_m2 = 1.0;
  const WindRoseOptions options{.num_directions = 4, .speeds_mps = {2.0, 100.0}};
  const ApproachPlanner planner(meadow.map, meadow.hazards, request, Nimble(), ApproachOptions{});
  for (const Plan& plan : PlanWindRose(planner, options).plans) {
    CHECK(plan.verdict == Verdict::kRejected);
    CHECK(plan.reject_reason == RejectReason::kTooSmall);
    CHECK_FALSE(plan.approach);
  }
  const WindRose rose = RoseOn(meadow, options);
  for (size_t i = 0; i < 4; ++i) {
    CHECK(rose.At(1, i).reject_reason == RejectReason::kWindTooStrong);
  }
}

TEST_CASE("wind rose: one that nobody wants any more stops before the next wind") {
  const Scene meadow = FlatMeadow(120, 120);
  const ApproachPlanner planner(
      meadow.map, meadow.hazards, InWind(std::nullopt), Nimble(), ApproachOptions{});
  int num_winds = 0;
  CHECK_THROWS_AS(PlanWindRose(planner,
                               {4, {1.0, 2.0}},
                               [&num_winds] {
                                 if (++num_winds == 3) throw std::runtime_error("nobody waits");
                               }),
                  std::runtime_error);
  CHECK(num_winds == 3);
}

TEST_CASE("wind rose: options are checked") {
  const auto check = [](const WindRoseOptions& options) { options.Check(); };
  CHECK_NOTHROW(check({}));
  CHECK_THROWS_AS(check({.num_directions = 0}), std::invalid_argument);
  CHECK_THROWS_AS(check({.num_directions = 100000}), std::invalid_argument);
  CHECK_THROWS_AS(check({.num_directions = 4, .speeds_mps = {}}), std::invalid_argument);
  CHECK_THROWS_AS(check({.num_directions = 4, .speeds_mps = {3.0, 3.0}}), std::invalid_argument);
  CHECK_THROWS_AS(check({.num_directions = 4, .speeds_mps = {-1.0}}), std::invalid_argument);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  CHECK_THROWS_AS(check({.num_directions = 4, .speeds_mps = {kInfinity}}), std::invalid_argument);
  CHECK_THROWS_WITH(check({.num_directions = 0}),
                    "wind_rose.num_directions = 0: must be in [1, 3600]");
}

}  // namespace
}  // namespace freelsd
