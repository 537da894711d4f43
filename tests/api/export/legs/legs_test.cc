#include "api/export/legs/legs.h"

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

namespace freelsd {
namespace {

const GeoPoint kOrigin{47.0, 8.0, 400.0};

FlightContext ContextIn(const std::string& datum) { return {"f", datum, LocalFrame(kOrigin)}; }

// One leg of 300 m to the east, 120 m above the origin.
NextLook OneLeg() {
  NextLook look;
  LookLeg leg;
  leg.from_in_world = {-150.0, 40.0, 120.0};
  leg.to_in_world = {150.0, 40.0, 120.0};
  leg.heading = 0.5 * kPi;
  leg.transit_m = 321.0;
  leg.expected_gain = 1.25;
  leg.places = {{{0.0, 50.0, 3.0}, 0, 0.75}, {{60.0, 50.0, 3.0}, std::nullopt, 0.5}};
  look.legs = {leg};
  look.expected_gain = 1.25;
  look.landing_value = 2.5;
  look.photo_spacing_m = 30.0;
  look.photo_extent_m = {100.0, 160.0};
  look.height_above_ground_m = 100.0;
  look.turn_radius_m = 40.0;
  return look;
}

std::string RefusalOf(const NextLook& look, const std::string& datum) {
  try {
    LegsPlan(look, ContextIn(datum), {});
  } catch (const ApiError& error) {
    return error.code();
  }
  return "";
}

TEST_CASE("legs: GeoJSON names the sites of the places, and null where there is none") {
  const nlohmann::json answer = LegsJson(OneLeg(), {{"f-r1", "unverified"}}, ContextIn("unknown"));
  REQUIRE(answer["features"].size() == 1);
  const nlohmann::json& leg = answer["features"][0];
  CHECK(leg["properties"]["heading_deg"] == 90.0);
  CHECK(leg["properties"]["length_m"] == 300.0);
  CHECK(leg["properties"]["altitude_m"].get<double>() == doctest::Approx(520.0).epsilon(1e-4));
  CHECK(leg["properties"]["places"][0]["site_id"] == "f-r1");
  CHECK(leg["properties"]["places"][0]["verdict"] == "unverified");
  CHECK(leg["properties"]["places"][1]["site_id"].is_null());
  CHECK(answer["landing_value"] == 2.5);
  CHECK(answer["photo_across_m"] == 160.0);
}

TEST_CASE("legs: a survey's polygon makes one transect, and its items lead straight into the leg") {
  const nlohmann::json plan = nlohmann::json::parse(LegsPlan(OneLeg(), ContextIn("amsl"), {}));
  const nlohmann::json& survey = plan["mission"]["items"][0];
  CHECK(survey["complexItemType"] == "survey");
  CHECK(survey["angle"] == 90.0);
  const LocalFrame frame(kOrigin);
  const auto in_world = [&frame](const nlohmann::json& latitude, const nlohmann::json& longitude) {
    return frame.WorldFromGeo({latitude, longitude, 520.0});
  };
  const nlohmann::json& polygon = survey["polygon"];
  REQUIRE(polygon.size() == 4);
  const double width =
      (in_world(polygon[0][0], polygon[0][1]) - in_world(polygon[3][0], polygon[3][1])).norm();
  const nlohmann::json& transect = survey["TransectStyleComplexItem"];
  CHECK(width < transect["CameraCalc"]["AdjustedFootprintSide"].get<double>());
  CHECK(transect["CameraShots"] == 11);
  const auto waypoint = [&](size_t i) {
    const nlohmann::json& params = transect["Items"][i]["params"];
    return in_world(params[4], params[5]);
  };
  // Metres; the world's frame is flat, the ellipsoid is not.
  constexpr double kMaxErrorM = 0.1;
  CHECK(std::abs(waypoint(0).x() + 190.0) < kMaxErrorM);
  CHECK(std::abs(waypoint(1).x() + 150.0) < kMaxErrorM);
  CHECK(std::abs(waypoint(3).x() - 150.0) < kMaxErrorM);
  CHECK(std::abs(waypoint(5).x() - 190.0) < kMaxErrorM);
  CHECK(std::abs(waypoint(5).y() - 40.0) < kMaxErrorM);
}

TEST_CASE("legs: no plan without known altitudes, and none without legs") {
  CHECK(RefusalOf(OneLeg(), "amsl").empty());
  CHECK(RefusalOf(OneLeg(), "unknown") == "AltitudeUnknown");
  CHECK(RefusalOf(NextLook(), "amsl") == "NothingToLookAt");
}

}  // namespace
}  // namespace freelsd
