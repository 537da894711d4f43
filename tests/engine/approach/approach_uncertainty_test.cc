// What the map does not know for certain has to be cleared as well.
#include <limits>

#include <doctest/doctest.h>

#include "tests/engine/approach/scene.h"

namespace freelsd {
namespace {

using scene::AddBlock;
using scene::Box;
using scene::FlatMeadow;
using scene::Nimble;
using scene::Request;
using scene::Scene;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

PlanRequest IntoNorthWind() { return Request(Box({-2, -2}, {2, 2}), Eigen::Vector2d(0.0, -4.0)); }

Plan PlanOn(const Scene& on, const ApproachOptions& options = {}) {
  return PlanApproach(on.map, on.hazards, IntoNorthWind(), Nimble(), options);
}

TEST_CASE("uncertainty: a map that may lean needs more clearance, the more the farther out") {
  // Below the path at 40 m, which is 8.7 m up there, with the 2 m margin: 3 m to spare.
  Scene meadow = FlatMeadow(240, 240);
  AddBlock(meadow, {-5, -41}, {5, -39}, 3.5);
  CHECK(PlanOn(meadow).verdict == Verdict::kLandable);
  meadow.map.tilt_sd_deg = 1.5;  // 2.1 m at 40 m, doubled sigma
  CHECK(PlanOn(meadow).verdict == Verdict::kLandable);
  meadow.map.tilt_sd_deg = 3.0;  // 4.2 m
  const Plan plan = PlanOn(meadow, scene::OneWay());
  CHECK(plan.verdict == Verdict::kRejected);
  CHECK(plan.reject_reason == RejectReason::kApproachBlocked);
  CHECK(PlanOn(meadow, {.tilt_sigma = 0.0}).verdict == Verdict::kLandable);
}

TEST_CASE("uncertainty: the circle clears the lean of its own distance from touchdown") {
  // Path height 10 m, both circles above ground that is 6 m up beyond their near side.
  Scene meadow = FlatMeadow(240, 240);
  const double start_y = -ApproachDistance(Nimble(), 4.0);
  AddBlock(meadow, {-60, start_y - 30}, {60, start_y - 12}, 6.0);
  CHECK(PlanOn(meadow).verdict == Verdict::kLandable);
  meadow.map.tilt_sd_deg = 1.5;  // 3.4 m at 65 m
  const Plan plan = PlanOn(meadow, scene::OneWay());
  CHECK(plan.verdict == Verdict::kRejected);
  CHECK(plan.reject_reason == RejectReason::kLoiterBlocked);
}

// Just outside the corridor, the strip's side and its end; in metres from touchdown, flying north.
constexpr double kBesideM = 4.0;

TEST_CASE(
    "uncertainty: what stands beside the path may stand in it, where the map may be shifted") {
  Aircraft aircraft = Nimble();
  aircraft.max_failure_probability = 1.0;  // what counts here are the margins
  const double side = aircraft.path_half_width_m + kBesideM;
  const double end = aircraft.ground_roll_m + kBesideM;
  const Eigen::Vector2d places[] = {{side, -25.0}, {-side, -25.0}, {side, 13.0}, {0.0, end}};
  for (const Eigen::Vector2d& place : places) {
    CAPTURE(place.x());
    CAPTURE(place.y());
    Scene meadow = FlatMeadow(240, 240);
    // Touches down at the origin alone, so that the disc is not what refuses.
    scene::ForCells(meadow, place.array() - 1.0, place.array() + 1.0, [&](int row, int col) {
      meadow.map.upper(row, col) += 6.0f;
      meadow.hazards.hazard(row, col) = kHazard;
    });
    const PlanRequest request = Request(Box({-0.9, -0.9}, {0.9, 0.9}), Eigen::Vector2d(0.0, -4.0));
    const auto plan_with = [&](const ApproachOptions& options) {
      return PlanApproach(meadow.map, meadow.hazards, request, aircraft, options);
    };
    ApproachOptions with_margin = scene::OneWay();
    with_margin.path_margin_sigma = 2.0;
    ApproachOptions no_margin = with_margin;
    no_margin.path_margin_sigma = 0.0;
    CHECK(plan_with(with_margin).verdict == Verdict::kLandable);
    meadow.map.position_sd_m = 2.0;
    CHECK(plan_with(no_margin).verdict == Verdict::kLandable);
    const Plan plan = plan_with(with_margin);
    CHECK(plan.verdict == Verdict::kRejected);
    const bool is_below_final = place.y() < 0.0;
    CHECK((plan.reject_reason == RejectReason::kApproachBlocked) == is_below_final);
  }
}

TEST_CASE("uncertainty: without a ground roll a shifted map makes none") {
  Scene meadow = FlatMeadow(240, 240);
  meadow.map.position_sd_m = 2.0;
  scene::ForCells(meadow, {-5.0, 12.0}, {5.0, 14.0}, [&](int row, int col) {
    meadow.hazards.hazard(row, col) = kHazard;
  });
  Aircraft aircraft = Nimble();
  const PlanRequest request = Request(Box({-0.9, -0.9}, {0.9, 0.9}), Eigen::Vector2d(0.0, -4.0));
  CHECK(PlanApproach(meadow.map, meadow.hazards, request, aircraft, {}).verdict ==
        Verdict::kRejected);
  aircraft.ground_roll_m = 0.0;
  CHECK(PlanApproach(meadow.map, meadow.hazards, request, aircraft, {}).verdict ==
        Verdict::kLandable);
}

TEST_CASE("uncertainty: what is unknown about the map is never taken for zero") {
  Scene meadow = FlatMeadow(240, 240);
  meadow.map.position_sd_m = kNaN;
  CHECK(PlanOn(meadow).verdict == Verdict::kRejected);
  meadow.map.position_sd_m = 0.0;
  CHECK(PlanOn(meadow).verdict == Verdict::kLandable);
  meadow.map.tilt_sd_deg = kNaN;
  CHECK(PlanOn(meadow).verdict == Verdict::kRejected);
  meadow.map.tilt_sd_deg = 0.0;
  meadow.map.standard_deviation.release();
  CHECK_THROWS_AS(PlanOn(meadow), std::invalid_argument);
}

}  // namespace
}  // namespace freelsd
