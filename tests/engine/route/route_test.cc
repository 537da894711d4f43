// Routes whose times and places are computed by hand.
#include "engine/route/route.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <doctest/doctest.h>

namespace freelsd {
namespace {

// 1 km north, then 1 km east, at 47 N; 500 m high, 600 m at the corner.
std::vector<GeoPoint> Corner() {
  const LocalFrame frame({47.0, 8.0, 0.0});
  const GeoPoint north = frame.GeoFromWorld({0.0, 1000.0, 0.0});
  const GeoPoint east = frame.GeoFromWorld({1000.0, 1000.0, 0.0});
  return {{47.0, 8.0, 500.0},
          {north.latitude_deg, north.longitude_deg, 600.0},
          {east.latitude_deg, east.longitude_deg, 600.0}};
}

Eigen::Vector2d From47N(const GeoPoint& place) {
  return LocalFrame({47.0, 8.0, 0.0})
      .WorldFromGeo({place.latitude_deg, place.longitude_deg, 0.0})
      .head<2>();
}

TEST_CASE("route: a moment each second in calm air") {
  const auto moments = MomentsOf(Corner(), 20.0, {0.0, 0.0}, {});
  REQUIRE(moments.size() == 100);
  CHECK(moments[0].time_s == 0.0);
  CHECK(moments[25].place.altitude_m == doctest::Approx(550.0));
  CHECK(From47N(moments[25].place).y() == doctest::Approx(500.0).epsilon(1e-4));
  CHECK(std::abs(std::remainder(moments[25].heading_deg, 360.0)) < 0.1);
  CHECK(From47N(moments[75].place).x() == doctest::Approx(500.0).epsilon(1e-3));
  CHECK(moments[75].heading_deg == doctest::Approx(90.0).epsilon(0.001));
  CHECK(moments[75].distance_m == doctest::Approx(1500.0).epsilon(1e-4));
}

TEST_CASE("route: wind changes the times, and the aircraft stays on the leg") {
  // 12 m/s from the side: 16 m/s are left of 20. Then 12 m/s from behind.
  const auto moments = MomentsOf(Corner(), 20.0, {12.0, 0.0}, {});
  const double first_leg_s = 1000.0 / 16.0;
  const double second_leg_s = 1000.0 / 32.0;
  CHECK(moments.size() == doctest::Approx(std::ceil(first_leg_s + second_leg_s)));
  CHECK(std::abs(From47N(moments[30].place).x()) < 0.1);
  CHECK(moments[30].distance_m == doctest::Approx(480.0).epsilon(1e-3));
}

TEST_CASE("route: a leg against too strong a wind is refused by its point") {
  CHECK_THROWS_WITH_AS(MomentsOf(Corner(), 20.0, {-19.8, 0.0}, {}),
                       "route[2]: cannot be reached in this wind at this airspeed",
                       std::invalid_argument);
  CHECK_THROWS_WITH_AS(MomentsOf(Corner(), 20.0, {-20.5, 0.0}, {}),
                       "route[1]: cannot be reached in this wind at this airspeed",
                       std::invalid_argument);
  CHECK_THROWS_AS(MomentsOf({{47.0, 8.0, 1.0}, {47.0, 8.0, 2.0}}, 20.0, {0.0, 0.0}, {}),
                  std::invalid_argument);
  CHECK_THROWS_AS(MomentsOf({{47.0, 8.0, 1.0}, {50.0, 8.0, 1.0}}, 20.0, {0.0, 0.0}, {}),
                  std::invalid_argument);
}

TEST_CASE("route: the way across the date line is the short one") {
  const auto moments =
      MomentsOf({{0.0, 179.99, 100.0}, {0.0, -179.99, 100.0}}, 20.0, {0.0, 0.0}, {});
  CHECK(moments.size() == doctest::Approx(0.02 * 111319.5 / 20.0).epsilon(0.01));
  for (const RouteMoment& moment : moments) {
    CHECK(std::abs(moment.place.longitude_deg) > 179.98);
    CHECK(moment.heading_deg == doctest::Approx(90.0).epsilon(0.001));
  }
}

TEST_CASE("route: a climb is whole between its ends and nothing at the route's ends") {
  RouteChange change;
  change.from_m = 600.0;
  change.to_m = 1400.0;
  change.climb_m = 20.0;
  change.climb_slope = 0.1;
  const auto before = MomentsOf(Corner(), 20.0, {0.0, 0.0}, {});
  const auto changed = Changed(Corner(), change, {});
  const auto after = MomentsOf(changed, 20.0, {0.0, 0.0}, {});
  REQUIRE(after.size() == before.size());
  for (size_t i = 0; i < before.size(); ++i) {
    const double climb_m = after[i].place.altitude_m - before[i].place.altitude_m;
    const double expected_m = std::clamp(
        std::min(before[i].distance_m - 400.0, 1600.0 - before[i].distance_m) * 0.1, 0.0, 20.0);
    INFO(i);
    CHECK(climb_m == doctest::Approx(expected_m).epsilon(0.001));
    CHECK((From47N(after[i].place) - From47N(before[i].place)).norm() < 0.2);
  }
  CHECK(changed.front().altitude_m == 500.0);
  CHECK(changed.back().altitude_m == 600.0);
}

TEST_CASE("route: a change near the start grows no faster than its slope") {
  RouteChange change;
  change.to_m = 300.0;
  change.climb_m = 50.0;
  change.climb_slope = 0.1;
  const ChangedPart part = PartOf(Corner(), change, {});
  CHECK(part.begin_m == 0.0);
  CHECK(part.end_m == doctest::Approx(800.0));
  const auto changed = Changed(Corner(), change, {});
  CHECK(changed.front().altitude_m == 500.0);
  // 40 m are reached halfway.
  CHECK(changed[1].altitude_m == doctest::Approx(500.0 + 40.0 + 40.0).epsilon(0.001));
}

TEST_CASE("route: a part moved aside keeps its altitude and all its points") {
  RouteChange change;
  change.from_m = 900.0;
  change.to_m = 1100.0;
  change.offset_m = {100.0, 50.0};
  const auto changed = Changed(Corner(), change, {});
  // Two of the part in front of the corner, the corner, two behind it, both ends.
  REQUIRE(changed.size() == 7);
  const Eigen::Vector2d corner = From47N(changed[3]);
  CHECK(corner.x() == doctest::Approx(100.0).epsilon(0.001));
  CHECK(corner.y() == doctest::Approx(1050.0).epsilon(0.001));
  CHECK(changed[3].altitude_m == doctest::Approx(600.0));
}

TEST_CASE("route: a step of altitude at one place stays a step") {
  std::vector<GeoPoint> step = Corner();
  GeoPoint above = step[1];
  above.altitude_m += 100.0;
  step.insert(step.begin() + 2, above);
  step.back().altitude_m += 100.0;
  RouteChange change;
  change.from_m = 1500.0;
  change.to_m = 1500.0;
  change.climb_m = 10.0;
  const auto changed = Changed(step, change, {});
  const auto moments = MomentsOf(changed, 20.0, {0.0, 0.0}, {});
  CHECK(moments[49].place.altitude_m < 600.0);
  CHECK(moments[51].place.altitude_m == doctest::Approx(700.0));
  CHECK(moments[75].place.altitude_m == doctest::Approx(710.0).epsilon(0.001));
}

}  // namespace
}  // namespace freelsd
