// What lies before the disc, and what it means for the risk.
#include <doctest/doctest.h>

#include "tests/engine/approach/scene.h"

namespace freelsd {
namespace {

using scene::AddBlock;
using scene::Box;
using scene::FlatMeadow;
using scene::Nimble;
using scene::PlanOn;
using scene::Request;
using scene::Scene;

TEST_CASE("approach: a bank of meadow before the disc is no obstacle, a bank of soil is one") {
  // Flies north. The path is about 2.4 m high above the bank, which is 3 m high.
  Scene meadow = FlatMeadow(240, 240);
  scene::ForCells(meadow, {-120, -28}, {120, -9}, [&](int row, int col) {
    meadow.map.elevation(row, col) = meadow.map.upper(row, col) = 3.0f;
  });
  const PlanRequest request = Request(Box({-0.9, -0.9}, {0.9, 0.9}), Eigen::Vector2d(0.0, -4.0));
  CHECK(PlanOn(meadow, request, Nimble(), scene::OneWay()).verdict == Verdict::kLandable);
  // A strip of soil lies between bank and disc: the free ground has a gap.
  Scene gap = meadow;
  scene::ForCells(gap, {-120, -9}, {120, -7.5}, [&](int row, int col) {
    gap.hazards.hazard(row, col) = kHazard;
  });
  CHECK(PlanOn(gap, request, Nimble(), scene::OneWay()).reject_reason ==
        RejectReason::kApproachBlocked);
}

TEST_CASE("approach: every plan with a path tells its risk") {
  const PlanRequest request = Request(Box({-40, -4}, {40, 5}), Eigen::Vector2d(0.0, -4.0));
  Scene meadow = FlatMeadow(240, 240);
  const Plan plan = PlanOn(meadow, request);
  REQUIRE(plan.risk);
  CHECK(plan.risk->failure_probability < 0.01);
  AddBlock(meadow, {-120, 30}, {120, 32}, 6.3);
  const Plan blocked = PlanOn(
      meadow, Request(request.footprint, Eigen::Vector2d(0.0, 4.0)), Nimble(), scene::OneWay());
  REQUIRE(blocked.risk);
  CHECK(blocked.verdict == Verdict::kRejected);
  CHECK(blocked.risk->failure_probability > plan.risk->failure_probability);
}

}  // namespace
}  // namespace freelsd
