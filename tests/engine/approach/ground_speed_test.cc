// Ground speed on final, and the wind that leaves too little of it.
#include <cmath>

#include <doctest/doctest.h>

#include "engine/approach/approach.h"
#include "tests/engine/approach/scene.h"

namespace freelsd {
namespace {

using scene::Box;
using scene::FlatMeadow;
using scene::Nimble;
using scene::PlanOn;
using scene::Request;

TEST_CASE("approach: a final slower over ground than the aircraft needs is too strong a wind") {
  // Eq. 1 alone would give a final in both: it counts on cos(89 deg) of the wind.
  Aircraft aircraft = *AircraftProfile("techpod");
  aircraft.crosswind_uncertainty_deg = 89.0;
  const double airspeed_mps = 13.0 * std::cos(RadFromDeg(4.0));
  const auto plan_against = [&](double wind_mps) {
    PlanRequest request = Request(Box({-40, -40}, {40, 40}), Eigen::Vector2d(wind_mps, 0.0));
    return PlanOn(FlatMeadow(600, 600), request, aircraft);
  };
  const Plan fast_enough = plan_against(airspeed_mps - 3.01);
  REQUIRE(fast_enough.approach);
  CHECK(*fast_enough.approach->ground_speed == doctest::Approx(3.01));
  const Plan too_slow = plan_against(airspeed_mps - 2.99);
  CHECK(too_slow.verdict == Verdict::kRejected);
  CHECK(too_slow.reject_reason == RejectReason::kWindTooStrong);
  CHECK_FALSE(too_slow.approach);
  CHECK(too_slow.reject_detail.find("3.0 m/s are needed") != std::string::npos);
  CHECK(plan_against(60.0).reject_reason == RejectReason::kWindTooStrong);
}

TEST_CASE("approach: the ground speed on final is told where the wind is known") {
  const auto plan_in = [](const std::optional<Eigen::Vector2d>& wind) {
    return PlanOn(FlatMeadow(600, 600), Request(Box({-40, -40}, {40, 40}), wind));
  };
  const Aircraft aircraft = Nimble();
  const double airspeed_mps =
      aircraft.landing_airspeed_mps * std::cos(RadFromDeg(aircraft.flight_path_angle_deg));
  CHECK(*plan_in(Eigen::Vector2d(0.0, -5.0)).approach->ground_speed ==
        doctest::Approx(airspeed_mps - 5.0));
  CHECK(*plan_in(Eigen::Vector2d(0.0, 0.0)).approach->ground_speed ==
        doctest::Approx(airspeed_mps));
  CHECK_FALSE(plan_in(std::nullopt).approach->ground_speed);
}

}  // namespace
}  // namespace freelsd
