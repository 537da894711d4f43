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

TEST_CASE("approach: a plan without one says so") {
  CHECK(ErrorOf([] { ApproachJson(Plan{}, Context()); }) == "409 NoApproach");
}

}  // namespace
}  // namespace freelsd
