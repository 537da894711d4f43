// Which touchdowns are tried.
#include <cmath>

#include <doctest/doctest.h>

#include "tests/engine/approach/scene.h"

namespace freelsd {
namespace {

using scene::Box;
using scene::FlatMeadow;
using scene::Nimble;
using scene::Request;
using scene::Scene;

// A shallow field, flown into from the south over a wall with one gap, as wide as the corridor and
// a little more.
Plan PlanThroughGap(double gap_east, const ApproachOptions& options) {
  Scene meadow = FlatMeadow(240, 320);
  const double half_width = Nimble().path_half_width_m + 5.0;
  scene::ForCells(meadow, {-160, -21}, {160, -19}, [&](int row, int col) {
    const double east = meadow.CellCenter(row, col).x();
    if (std::abs(east - gap_east) <= half_width) return;
    meadow.map.upper(row, col) += 7.0f;
    meadow.hazards.hazard(row, col) = kHazard;
  });
  const PlanRequest request = Request(Box({-90, -8}, {90, 8}), Eigen::Vector2d(0.0, -4.0));
  // The touchdown may be farther aside than the gap is wide; what counts here is the search.
  Aircraft aircraft = Nimble();
  aircraft.max_failure_probability = 1.0;
  return PlanApproach(meadow.map, meadow.hazards, request, aircraft, options);
}

TEST_CASE("approach: a field with room for a single final is found by the reserve alone") {
  ApproachOptions no_reserve = scene::OneWay();
  no_reserve.max_num_reserve_candidates = 0;
  int num_missed = 0;
  for (const double gap_east : {-61.3, -36.1, -17.4, 11.2, 33.7, 58.9}) {
    CAPTURE(gap_east);
    const Plan plan = PlanThroughGap(gap_east, scene::OneWay());
    CHECK(plan.verdict == Verdict::kLandable);
    CHECK(std::abs(plan.touchdown_in_world.x() - gap_east) < 3.0);
    CHECK_FALSE(plan.rejections.empty());
    if (PlanThroughGap(gap_east, no_reserve).verdict == Verdict::kRejected) ++num_missed;
  }
  CHECK(num_missed >= 2);
}

TEST_CASE("approach: a reserve makes no good place of a bad one") {
  ApproachOptions many = scene::OneWay();
  many.max_num_reserve_candidates = 20000;
  const Plan plan = PlanThroughGap(500.0, many);
  CHECK(plan.verdict == Verdict::kRejected);
  CHECK(plan.reject_reason == RejectReason::kApproachBlocked);
  ApproachOptions no_reserve = scene::OneWay();
  no_reserve.max_num_reserve_candidates = 0;
  CHECK(PlanThroughGap(500.0, no_reserve).verdict == Verdict::kRejected);
}

}  // namespace
}  // namespace freelsd
