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

constexpr double kSameM = 1e-9;

// Blocks and gaps around a field, so that every verdict occurs.
Scene Obstructed() {
  Scene meadow = FlatMeadow(200, 220);
  AddBlock(meadow, {-60, 30}, {-40, 60}, 9.0);
  AddBlock(meadow, {20, -70}, {60, -62}, 14.0);
  AddBlock(meadow, {70, 10}, {74, 14}, 30.0);
  AddUnseen(meadow, {-30, -90}, {10, -70});
  return meadow;
}

Eigen::Vector2d WindOf(const WindRose& rose, size_t speed, int direction) {
  return rose.speeds[speed] * DirectionOf(2.0 * kPi * direction / rose.num_directions);
}

WindRose RoseOn(const Scene& on, const WindRoseOptions& rose_options) {
  return PlanWindRose(on.map,
                      on.hazards,
                      Request(Box({-40, -40}, {40, 40}), std::nullopt),
                      Nimble(),
                      ApproachOptions{},
                      rose_options);
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

TEST_CASE("wind rose: each of its entries is what a plan for that wind answers") {
  const Scene meadow = Obstructed();
  const WindRose rose = RoseOn(meadow, {.num_directions = 24, .speeds_mps = {1.0, 3.0, 6.5, 40.0}});
  REQUIRE(rose.entries.size() == 24 * 4);
  int num_by_verdict[3] = {};
  for (size_t speed = 0; speed < rose.speeds.size(); ++speed) {
    for (int i = 0; i < rose.num_directions; ++i) {
      const Plan plan = PlanApproach(meadow.map,
                                     meadow.hazards,
                                     Request(Box({-40, -40}, {40, 40}), WindOf(rose, speed, i)),
                                     Nimble(),
                                     ApproachOptions{});
      const WindRoseEntry& entry = rose.At(speed, static_cast<size_t>(i));
      CAPTURE(speed);
      CAPTURE(i);
      ++num_by_verdict[static_cast<int>(entry.verdict)];
      CHECK(entry.verdict == plan.verdict);
      CHECK(entry.reject_reason == plan.reject_reason);
      CHECK((entry.touchdown_in_world - plan.touchdown_in_world).norm() < kSameM);
      CHECK(entry.hazard_distance == plan.hazard_distance);
      if (!plan.approach) continue;
      CHECK(entry.min_clearance == doctest::Approx(plan.approach->min_clearance));
      CHECK(entry.unseen_ratio == plan.approach->unseen_ratio);
      CHECK(entry.approach_height == plan.approach->approach_height);
      CHECK(std::abs(WrapAngle(entry.heading - plan.approach->heading)) < kSameM);
      CHECK(entry.loiter_direction == plan.approach->loiter_direction);
    }
  }
  CHECK(num_by_verdict[static_cast<int>(Verdict::kRejected)] > 0);
  CHECK(num_by_verdict[static_cast<int>(Verdict::kRejected)] < 24 * 4);
}

TEST_CASE("wind rose: a look-up of a wind of the table is its entry") {
  const WindRose rose = RoseOn(Obstructed(), {.num_directions = 16, .speeds_mps = {1.0, 4.0}});
  for (size_t speed = 0; speed < rose.speeds.size(); ++speed) {
    for (int i = 0; i < rose.num_directions; ++i) {
      const auto found = LookUp(rose, WindOf(rose, speed, i));
      const WindRoseEntry& entry = rose.At(speed, static_cast<size_t>(i));
      REQUIRE(found);
      CHECK(found->verdict == entry.verdict);
      CHECK(found->touchdown_in_world == entry.touchdown_in_world);
      CHECK(found->clearance_ratio == doctest::Approx(entry.clearance_ratio));
    }
  }
}

TEST_CASE("wind rose: between the table's winds no look-up is better than any neighbour") {
  const WindRose rose = RoseOn(Obstructed(), {.num_directions = 16, .speeds_mps = {0.0, 2.0, 4.0}});
  const double step = 2.0 * kPi / rose.num_directions;
  for (size_t speed = 0; speed + 1 < rose.speeds.size(); ++speed) {
    for (int i = 0; i < rose.num_directions; ++i) {
      const double between = 0.5 * (rose.speeds[speed] + rose.speeds[speed + 1]);
      const auto found = LookUp(rose, between * DirectionOf(step * (i + 0.3)));
      REQUIRE(found);
      const auto next = static_cast<size_t>((i + 1) % rose.num_directions);
      for (const size_t row : {speed, speed + 1}) {
        for (const size_t direction : {static_cast<size_t>(i), next}) {
          const WindRoseEntry& neighbour = rose.At(row, direction);
          CHECK(found->verdict >= neighbour.verdict);
          CHECK_FALSE(found->clearance_ratio > neighbour.clearance_ratio);
          CHECK_FALSE(found->unseen_ratio < neighbour.unseen_ratio);
          CHECK(found->hazard_distance <= neighbour.hazard_distance);
          const bool is_same_place = found->touchdown_in_world == neighbour.touchdown_in_world;
          if (!is_same_place) CHECK(found->verdict != Verdict::kLandable);
        }
      }
    }
  }
}

TEST_CASE("wind rose: in a calm the best direction, beyond the table nothing") {
  const WindRose rose = RoseOn(Obstructed(), {.num_directions = 16, .speeds_mps = {0.0, 4.0}});
  const auto calm = LookUp(rose, Eigen::Vector2d(0.0, 0.2));
  REQUIRE(calm);
  for (size_t i = 0; i < 16; ++i) CHECK(calm->verdict <= rose.At(0, i).verdict);
  CHECK_FALSE(LookUp(rose, Eigen::Vector2d(0.0, 4.1)));
  CHECK_FALSE(LookUp(rose, Eigen::Vector2d(std::nan(""), 0.0)));
  CHECK_FALSE(LookUp(WindRose{}, Eigen::Vector2d(1.0, 0.0)));
  // Weaker than the weakest: the final would be longer than any that was looked at.
  const WindRose windy = RoseOn(Obstructed(), {.num_directions = 4, .speeds_mps = {2.0, 4.0}});
  CHECK_FALSE(LookUp(windy, Eigen::Vector2d(0.0, 1.0)));
}

TEST_CASE("wind rose: a region that is refused is refused in every wind, and too strong is said") {
  const Scene meadow = FlatMeadow(120, 120);
  PlanRequest request = Request(Box({-40, -40}, {40, 40}), std::nullopt);
  request.area_m2 = 1.0;
  const WindRoseOptions options{.num_directions = 4, .speeds_mps = {2.0, 100.0}};
  const WindRose refused =
      PlanWindRose(meadow.map, meadow.hazards, request, Nimble(), ApproachOptions{}, options);
  for (const WindRoseEntry& entry : refused.entries) {
    CHECK(entry.verdict == Verdict::kRejected);
    CHECK(entry.reject_reason == RejectReason::kTooSmall);
    CHECK(std::isnan(entry.clearance_ratio));
  }
  const WindRose rose = RoseOn(meadow, options);
  for (size_t i = 0; i < 4; ++i) {
    CHECK(rose.At(1, i).reject_reason == RejectReason::kWindTooStrong);
  }
  const auto between = LookUp(rose, Eigen::Vector2d(0.0, 50.0));
  REQUIRE(between);
  CHECK(between->reject_reason == RejectReason::kWindTooStrong);
}

TEST_CASE("wind rose: options are checked") {
  const auto check = [](const WindRoseOptions& options) { options.Check(); };
  CHECK_NOTHROW(check({}));
  CHECK_THROWS_AS(check({.num_directions = 0}), std::invalid_argument);
  CHECK_THROWS_AS(check({.num_directions = 100000}), std::invalid_argument);
  CHECK_THROWS_AS(check({.num_directions = 4, .speeds_mps = {}}), std::invalid_argument);
  CHECK_THROWS_AS(check({.num_directions = 4, .speeds_mps = {3.0, 3.0}}), std::invalid_argument);
  CHECK_THROWS_AS(check({.num_directions = 4, .speeds_mps = {-1.0}}), std::invalid_argument);
  const double kInfinity = std::numeric_limits<double>::infinity();
  CHECK_THROWS_AS(check({.num_directions = 4, .speeds_mps = {kInfinity}}), std::invalid_argument);
  CHECK_THROWS_WITH(check({.num_directions = 0}),
                    "wind_rose.num_directions = 0: must be in [1, 3600]");
}

}  // namespace
}  // namespace freelsd
