// A stored approach, checked again on the map of a later flight.
#include <doctest/doctest.h>

#include "tests/engine/approach/scene.h"

namespace freelsd {
namespace {

using scene::AddBlock;
using scene::AddUnseen;
using scene::FlatMeadow;
using scene::Nimble;
using scene::Scene;

// From the north: the final leads north over the ground south of the touchdown.
const Eigen::Vector2d kWind(0.0, -4.0);
constexpr int kNumCells = 240;

Approach PlannedApproach() {
  const Scene meadow = FlatMeadow(kNumCells, kNumCells);
  const Plan plan =
      scene::PlanOn(meadow, scene::Request(scene::Box({-5.0, -5.0}, {5.0, 5.0}), kWind));
  REQUIRE(plan.verdict == Verdict::kLandable);
  return *plan.approach;
}

ApproachCheck CheckOn(const Scene& later,
                      const std::optional<Eigen::Vector2d>& wind = kWind,
                      const Aircraft& aircraft = Nimble()) {
  return CheckApproach(PlannedApproach(), later.map, later.hazards, aircraft, wind, {});
}

TEST_CASE(
    "approach check: what was planned holds on the same map, and on one of another altitude") {
  for (const double altitude : {0.0, 47.0, -300.0}) {
    const Scene later = scene::Meadow(
        kNumCells, kNumCells, 1.0, [altitude](const Eigen::Vector2d&) { return altitude; });
    const ApproachCheck check = CheckOn(later);
    CHECK_FALSE(check.rejection);
    CHECK(check.is_covered);
  }
}

TEST_CASE("approach check: the first rule that the ground breaks is told, wherever it is") {
  struct Case {
    Eigen::Vector2d middle;
    RejectReason reason;
    const char* text;
  };
  for (const Case& each : {Case{{0.0, 7.0}, RejectReason::kNoSafeTouchdown, "a hazard is"},
                           Case{{0.0, 17.0}, RejectReason::kNoSafeTouchdown, "ground roll"},
                           Case{{0.0, -30.0}, RejectReason::kApproachBlocked, "the final is"}}) {
    Scene later = FlatMeadow(kNumCells, kNumCells);
    const Eigen::Vector2d touchdown = PlannedApproach().touchdown_in_world.head<2>();
    const Eigen::Vector2d half(1.5, 1.5);
    AddBlock(later, touchdown + each.middle - half, touchdown + each.middle + half, 12.0);
    const ApproachCheck check = CheckOn(later);
    REQUIRE(check.rejection);
    CHECK(check.rejection->reason == each.reason);
    CHECK(check.rejection->detail.find(each.text) != std::string::npos);
    CHECK(check.is_covered);
  }
  Scene later = FlatMeadow(kNumCells, kNumCells);
  const Approach approach = PlannedApproach();
  const Eigen::Vector2d center = approach.loiter_center_in_world.head<2>();
  const Eigen::Vector2d start = approach.approach_start_in_world.head<2>();
  const Eigen::Vector2d far_side = 2.0 * center - start;
  AddBlock(later, far_side.array() - 2.0, far_side.array() + 2.0, 14.0);
  REQUIRE(CheckOn(later).rejection);
  CHECK(CheckOn(later).rejection->reason == RejectReason::kLoiterBlocked);
}

TEST_CASE(
    "approach check: unseen ground breaks no rule and covers nothing, seen things still count") {
  const Eigen::Vector2d touchdown = PlannedApproach().touchdown_in_world.head<2>();
  Scene later = FlatMeadow(kNumCells, kNumCells);
  AddUnseen(later, touchdown.array() - 14.0, touchdown.array() + 14.0);
  CHECK_FALSE(CheckOn(later).rejection);
  CHECK_FALSE(CheckOn(later).is_covered);
  // The disc is unseen: heights follow the ground below the rest of the final.
  AddBlock(later, touchdown - Eigen::Vector2d(3, 36), touchdown - Eigen::Vector2d(-3, 31), 12.0);
  REQUIRE(CheckOn(later).rejection);
  CHECK(CheckOn(later).rejection->reason == RejectReason::kApproachBlocked);
  CHECK_FALSE(CheckOn(later).is_covered);
  // One cell of the final alone.
  Scene hole = FlatMeadow(kNumCells, kNumCells);
  const Eigen::Vector2d place = touchdown - Eigen::Vector2d(0.0, 25.0);
  AddUnseen(hole, place.array() - 0.5, place.array() + 0.5);
  CHECK_FALSE(CheckOn(hole).rejection);
  CHECK_FALSE(CheckOn(hole).is_covered);
}

TEST_CASE("approach check: a map that begins on the final shows what stands there") {
  const Approach approach = PlannedApproach();
  const double south_of = approach.touchdown_in_world.y() - 18.0;
  Scene later = FlatMeadow(kNumCells, kNumCells);
  later.map.grid.north_west_in_world.y() = south_of;
  later.hazards.grid = later.map.grid;
  CHECK_FALSE(CheckOn(later).is_covered);
  CHECK_FALSE(CheckOn(later).rejection);
  const Eigen::Vector2d place = approach.touchdown_in_world.head<2>() - Eigen::Vector2d(0, 33);
  AddBlock(later, place.array() - 2.0, place.array() + 2.0, 12.0);
  REQUIRE(CheckOn(later).rejection);
  CHECK(CheckOn(later).rejection->reason == RejectReason::kApproachBlocked);
  later.map.grid.north_west_in_world.y() = south_of - 1000.0;
  later.hazards.grid = later.map.grid;
  CHECK_FALSE(CheckOn(later).rejection);
}

TEST_CASE("approach check: a map whose deviation is unknown says nothing, unknown wind asks more") {
  Scene later = FlatMeadow(kNumCells, kNumCells);
  const Eigen::Vector2d touchdown = PlannedApproach().touchdown_in_world.head<2>();
  // Beyond the start of the final, where a tail wind makes it begin.
  AddBlock(later, touchdown - Eigen::Vector2d(3, 90), touchdown - Eigen::Vector2d(-3, 86), 14.0);
  const double length = PlannedApproach().approach_distance;
  REQUIRE(length < 80.0);
  CHECK_FALSE(CheckOn(later).rejection);
  CHECK(CheckOn(later, std::nullopt).rejection);
  later.map.position_sd_m = std::nan("");
  CHECK_FALSE(CheckOn(later, std::nullopt).rejection);
  CHECK_FALSE(CheckOn(later).is_covered);
}

}  // namespace
}  // namespace freelsd
