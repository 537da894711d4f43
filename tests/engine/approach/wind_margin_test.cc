// What a weak wind and an unsteady wind do to final and circle.
#include <cmath>

#include <doctest/doctest.h>

#include "engine/approach/approach_geometry.h"
#include "tests/engine/approach/scene.h"

namespace freelsd {
namespace {

using scene::Box;
using scene::FlatMeadow;
using scene::Nimble;
using scene::PlanOn;
using scene::Request;
using scene::Scene;

constexpr double kSameM = 1e-9;
const Eigen::Vector2d kToTheNorth(0.0, 1.0);

const HeadingCase& Towards(const WindCase& wind, double heading_deg) {
  for (const HeadingCase& each : wind.headings) {
    if (std::abs(DegFromRad(each.heading) - heading_deg) < 1e-6) return each;
  }
  FAIL("no such heading");
  return wind.headings.front();
}

TEST_CASE("approach: a wind below 0.5 m/s counts in the final as it does in the circle") {
  const Aircraft techpod = *AircraftProfile("techpod");
  const WindCase wind = MakeWindCase(0.49 * kToTheNorth, techpod, ApproachOptions{});
  REQUIRE(wind.headings.size() == 36);
  const WindScenario from_behind = Towards(wind, 0.0).scenarios.front();
  const WindScenario from_ahead = Towards(wind, 180.0).scenarios.front();
  // It may turn by 30 degrees, so on each of these all of it may be from behind.
  for (const double heading_deg : {0.0, 10.0, 30.0, 330.0}) {
    CHECK(std::abs(Towards(wind, heading_deg).scenarios.front().approach_distance -
                   DownwindApproachDistance(techpod, 0.49)) < kSameM);
  }
  CHECK(std::abs(from_ahead.approach_distance - ApproachDistance(techpod, 0.0)) < kSameM);
  for (const HeadingCase& heading : wind.headings) {
    CHECK(heading.scenarios.front().loiter_radius == LoiterRadius(techpod, 0.49));
    CHECK(heading.scenarios.front().approach_distance >= ApproachDistance(techpod, 0.0) - kSameM);
  }
  CHECK(*from_behind.ground_speed - *from_ahead.ground_speed == doctest::Approx(2 * 0.49));
}

TEST_CASE("approach: without any wind, and without spread, nothing changes to the last digit") {
  const Aircraft techpod = *AircraftProfile("techpod");
  const WindCase calm = MakeWindCase(Eigen::Vector2d(0.0, 0.0), techpod, ApproachOptions{});
  const double airspeed = 13.0 * std::cos(RadFromDeg(4.0));
  for (const HeadingCase& heading : calm.headings) {
    CHECK(heading.scenarios.front().approach_distance ==
          airspeed / (13.0 * std::sin(RadFromDeg(4.0))) * 12.0);
    CHECK(heading.scenarios.front().loiter_radius == LoiterRadius(techpod, 0.0));
    CHECK(*heading.scenarios.front().ground_speed == airspeed);
  }
  const WindCase wind = MakeWindCase(5.5 * kToTheNorth, techpod, ApproachOptions{}, 0.0);
  const WindScenario& into_wind = wind.headings.front().scenarios.front();
  CHECK(into_wind.approach_distance == ApproachDistance(techpod, 5.5));
  CHECK(into_wind.loiter_radius == LoiterRadius(techpod, 5.5));
}

TEST_CASE("approach: the spread of the wind lengthens the final and widens the circle") {
  const Aircraft techpod = *AircraftProfile("techpod");
  const WindCase wind = MakeWindCase(5.5 * kToTheNorth, techpod, ApproachOptions{}, 1.0);
  const WindScenario& flown = wind.headings.front().scenarios.front();
  // Eq. 1 with 1 m/s less from ahead, and with 1 m/s more in the circle.
  const double sink = 13.0 * std::sin(RadFromDeg(4.0));
  CHECK(std::abs(flown.approach_distance - (ApproachDistance(techpod, 5.5) + 12.0 / sink)) <
        kSameM);
  CHECK(flown.loiter_radius == LoiterRadius(techpod, 6.5));
  // ground_speed is reported for the wind itself. The least ground speed must also hold in a gust.
  CHECK(*flown.ground_speed == doctest::Approx(13.0 * std::cos(RadFromDeg(4.0)) - 5.5));
  CHECK_FALSE(wind.is_too_strong);
  CHECK(MakeWindCase(5.5 * kToTheNorth, techpod, ApproachOptions{}, 4.6).is_too_strong);
  CHECK(MakeWindCase(0.3 * kToTheNorth, techpod, ApproachOptions{}, 9.8).is_too_strong);
  CHECK_THROWS_AS(MakeWindCase(kToTheNorth, techpod, ApproachOptions{}, NAN),
                  std::invalid_argument);
}

TEST_CASE("approach: the spread counts for the measured wind, not for one that is asked about") {
  const Scene meadow = FlatMeadow(600, 600);
  const Eigen::Vector2d measured = 4.0 * kToTheNorth;
  PlanRequest request = Request(Box({-40, -40}, {40, 40}), measured);
  const Plan steady = PlanOn(meadow, request);
  request.wind_spread_mps = 1.0;
  const Plan unsteady = PlanOn(meadow, request);
  REQUIRE((steady.approach && unsteady.approach));
  CHECK(unsteady.approach->approach_distance > steady.approach->approach_distance + 1.0);
  CHECK(unsteady.approach->loiter_radius > steady.approach->loiter_radius + 1.0);
  ApproachOptions off;
  off.wind_sigma = 0.0;
  CHECK(PlanOn(meadow, request, Nimble(), off).approach->approach_distance ==
        steady.approach->approach_distance);
  const ApproachPlanner planner(meadow.map, meadow.hazards, request, Nimble(), ApproachOptions{});
  CHECK(planner.PlanFor(measured).approach->approach_distance ==
        unsteady.approach->approach_distance);
  const Eigen::Vector2d asked(0.0, 4.000001);
  CHECK(planner.PlanFor(asked).approach->approach_distance < steady.approach->approach_distance);
}

}  // namespace
}  // namespace freelsd
