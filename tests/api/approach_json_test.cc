#include <cmath>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/api/errors.h"
#include "tests/api/plans.h"

namespace freelsd {
namespace {

TEST_CASE("approach: straight final, closed circle flown left, touchdown, unseen ground is null") {
  const FlightContext context = Context();
  const nlohmann::json answer = ApproachJson(LandablePlan(), context);
  const nlohmann::json& line = answer["features"][0];
  CHECK(line["properties"]["kind"] == "approach");
  CHECK(line["geometry"]["coordinates"].size() == 2);
  const GeoPoint start = context.local_frame.GeoFromWorld({0, -100, 17});
  CHECK(std::abs(line["geometry"]["coordinates"][0][1].get<double>() - start.latitude_deg) <
        kMaxPositionErrorDeg);
  CHECK(std::abs(line["geometry"]["coordinates"][0][2].get<double>() - 417.0) < kMaxAltitudeErrorM);
  const nlohmann::json& circle = answer["features"][1]["geometry"]["coordinates"];
  CHECK(answer["features"][1]["properties"]["kind"] == "loiter");
  CHECK(circle.front() == circle.back());
  CHECK(circle.front() == line["geometry"]["coordinates"][0]);
  // Northbound with the centre in the west: after the start the aircraft goes on north, then west.
  CHECK(circle[1][1] > circle[0][1]);
  CHECK(circle[1][0] < circle[0][0]);
  CHECK(answer["features"][2]["properties"]["kind"] == "touchdown");
  const nlohmann::json& profile = answer["profile"];
  CHECK(profile["distance_m"] == nlohmann::json::array({100.0, 50.0, 0.0}));
  CHECK(profile["terrain_m"][1].is_null());
  CHECK(profile["clearance_m"][1].is_null());
  CHECK(profile["clearance_m"][0] == 11.0);
  CHECK(std::abs(profile["path_m"][2].get<double>() - 405.0) < kMaxAltitudeErrorM);
}

TEST_CASE("approach: the go-around is a line with its point of no return, absent where none is") {
  Plan plan = LandablePlan();
  const auto features = [&plan] { return ApproachJson(plan, Context())["features"]; };
  // An older path, or one that nobody explained: nothing is known.
  CHECK_FALSE(features()[0]["properties"].contains("no_return_distance_m"));
  plan.approach->strip = LandingStrip{};
  CHECK(features()[0]["properties"]["no_return_distance_m"].is_null());
  CHECK(features().size() == 3);
  plan.approach->go_around = GoAround{.no_return_distance = 25.0,
                                      .start_in_world = {0, -25, 8},
                                      .end_in_world = {0, 75, 18},
                                      .climb_angle = std::atan(0.1),
                                      .unseen_ratio = 0.5};
  CHECK(features()[0]["properties"]["no_return_distance_m"] == 25.0);
  const nlohmann::json feature = features()[3];
  const nlohmann::json& properties = feature["properties"];
  CHECK(properties["kind"] == "go_around");
  CHECK(properties["no_return_distance_m"] == 25.0);
  CHECK(properties["height_m"] == 3.0);
  CHECK(properties["climb_angle_deg"] == 5.711);
  CHECK(properties["unseen_ratio"] == 0.5);
  CHECK(feature["geometry"]["type"] == "LineString");
  const nlohmann::json& line = feature["geometry"]["coordinates"];
  REQUIRE(line.size() == 2);
  CHECK(std::abs(line[0][2].get<double>() - 408.0) < kMaxAltitudeErrorM);
  CHECK(std::abs(line[1][2].get<double>() - 418.0) < kMaxAltitudeErrorM);
}

TEST_CASE("approach: a plan without one says so") {
  CHECK(ErrorOf([] { ApproachJson(Plan{}, Context()); }) == "409 NoApproach");
}

}  // namespace
}  // namespace freelsd
