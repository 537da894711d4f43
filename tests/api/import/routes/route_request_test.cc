// Requests for the insurance of a route: what is read, and what is refused by its name.
#include <algorithm>
#include <cmath>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "api/import/routes/routes.h"
#include "tests/api/errors.h"

namespace freelsd {
namespace {

void CheckRefused(const std::string& pointer, const std::function<void()>& call) {
  const std::string error = ErrorOf(call);
  INFO(error);
  CHECK(error.starts_with("422 "));
  CHECK(error.ends_with(" " + pointer));
}

nlohmann::json Point(double latitude_deg, double altitude_m) {
  return {{"latitude_deg", latitude_deg}, {"longitude_deg", 8.0}, {"altitude_m", altitude_m}};
}

nlohmann::json Request() {
  return {{"route", {Point(47.0, 500.0), Point(47.01, 600.0)}}, {"airspeed_mps", 15.0}};
}

nlohmann::json Item(int command, int frame, double latitude_deg, double altitude_m) {
  return {{"type", "SimpleItem"},
          {"command", command},
          {"frame", frame},
          {"params", {0, 0, 0, nullptr, latitude_deg, 8.0, altitude_m}}};
}

nlohmann::json Plan(const nlohmann::json& items) {
  return {{"fileType", "Plan"},
          {"mission",
           {{"cruiseSpeed", 16.0}, {"plannedHomePosition", {47.0, 8.0, 400.0}}, {"items", items}}}};
}

RouteRequest ParsePlan(const nlohmann::json& items) {
  return ParseRouteRequest({{"plan", Plan(items)}});
}

TEST_CASE("route request: points, speed and defaults") {
  const RouteRequest request = ParseRouteRequest(Request());
  REQUIRE(request.route.size() == 2);
  CHECK(request.route[1].altitude_m == 600.0);
  CHECK(request.airspeed_mps == 15.0);
  CHECK(request.altitude_datum == "unknown");
  CHECK(request.winds.empty());
  CHECK_FALSE(request.aircraft);
  CHECK(request.has_fixes);
}

TEST_CASE("route request: a wind with a spread becomes winds of its mean and covariance") {
  nlohmann::json object = Request();
  object["wind"] = {{"east_mps", 3.0}, {"north_mps", -1.0}, {"sd_mps", 2.0}};
  const auto winds = ParseRouteRequest(object).winds;
  REQUIRE(winds.size() == 5);
  double sum = 0.0;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  for (const WeightedWind& wind : winds) {
    sum += wind.weight;
    mean += wind.weight * wind.wind_in_world;
    const Eigen::Vector2d off = wind.wind_in_world - Eigen::Vector2d(3.0, -1.0);
    covariance += wind.weight * off * off.transpose();
  }
  CHECK(sum == doctest::Approx(1.0));
  CHECK((mean - Eigen::Vector2d(3.0, -1.0)).norm() < 1e-12);
  CHECK((covariance - 4.0 * Eigen::Matrix2d::Identity()).norm() < 1e-12);
  object["wind"].erase("sd_mps");
  CHECK(ParseRouteRequest(object).winds.size() == 1);
}

TEST_CASE("route request: weights are made to sum to 1, and winds that cannot blow are left out") {
  nlohmann::json object = Request();
  object["winds"] = {{{"east_mps", 1}, {"north_mps", 0}, {"weight", 3}},
                     {{"east_mps", 2}, {"north_mps", 0}, {"weight", 0}},
                     {{"east_mps", 3}, {"north_mps", 0}}};
  const auto winds = ParseRouteRequest(object).winds;
  REQUIRE(winds.size() == 2);
  CHECK(winds[0].weight == 0.75);
  CHECK(winds[1].weight == 0.25);
}

TEST_CASE("route request: what is wrong is named") {
  const auto with = [](const char* key, const nlohmann::json& value) {
    nlohmann::json object = Request();
    object[key] = value;
    return [object] { ParseRouteRequest(object); };
  };
  const auto without = [](const char* key) {
    nlohmann::json object = Request();
    object.erase(key);
    return [object] { ParseRouteRequest(object); };
  };
  CheckRefused("/airspeed_mps", without("airspeed_mps"));
  CheckRefused("/route", without("route"));
  CheckRefused("/route", with("route", {Point(47.0, 1.0)}));
  CheckRefused("/route/1/latitude_deg", with("route", {Point(47.0, 1.0), Point(97.0, 1.0)}));
  CheckRefused("/route", with("plan", Plan({Item(16, 3, 47.0, 10), Item(16, 3, 47.1, 10)})));
  CheckRefused("/winds", with("winds", nlohmann::json::array()));
  CheckRefused("/winds", with("winds", {{{"east_mps", 1}, {"north_mps", 0}, {"weight", 0}}}));
  CheckRefused("/winds/0/weight",
               with("winds", {{{"east_mps", 1}, {"north_mps", 0}, {"weight", -1}}}));
  CheckRefused("/wind/north_mps", with("wind", {{"east_mps", 1}}));
  CheckRefused("/altitude_datum", with("altitude_datum", "sea"));
  CheckRefused("/aircraft/profile", with("aircraft", "zeppelin"));
  CheckRefused("/with_fixes", with("with_fixes", 1));
  CheckRefused("/speed", with("speed", 1));
}

TEST_CASE("route request: a plan's waypoints, heights above home and speed") {
  const RouteRequest request = ParsePlan({Item(22, 3, 47.001, 30.0),
                                          Item(178, 2, 0.0, 0.0),
                                          Item(16, 3, 47.01, 100.0),
                                          Item(16, 0, 47.02, 700.0),
                                          Item(20, 2, 0.0, 0.0),
                                          Item(16, 3, 47.5, 1.0)});
  REQUIRE(request.route.size() == 5);
  CHECK(request.altitude_datum == "amsl");
  CHECK(request.airspeed_mps == 16.0);
  CHECK(request.route[0].altitude_m == 400.0);
  CHECK(request.route[1].altitude_m == 430.0);
  CHECK(request.route[2].altitude_m == 500.0);
  CHECK(request.route[3].altitude_m == 700.0);
  // Back above home.
  CHECK(request.route[4].latitude_deg == 47.0);
  CHECK(request.route[4].altitude_m == 700.0);
  CHECK(request.warnings.size() == 1);
}

TEST_CASE("route request: a survey's items count, and the route ends where the landing begins") {
  const nlohmann::json survey{
      {"type", "ComplexItem"},
      {"complexItemType", "survey"},
      {"TransectStyleComplexItem",
       {{"Items", {Item(16, 3, 47.01, 80.0), Item(206, 2, 0, 0), Item(16, 3, 47.02, 80.0)}}}}};
  const nlohmann::json landing{{"type", "ComplexItem"},
                               {"complexItemType", "fwLandingPattern"},
                               {"altitudesAreRelative", true},
                               {"landingApproachCoordinate", {47.03, 8.0, 40.0}},
                               {"landCoordinate", {47.04, 8.0, 0.0}}};
  const RouteRequest request = ParsePlan({survey, landing, Item(16, 3, 47.5, 1.0)});
  REQUIRE(request.route.size() == 3);
  CHECK(request.route[2].latitude_deg == 47.03);
  CHECK(request.route[2].altitude_m == 440.0);
  const RouteRequest landed =
      ParsePlan({Item(16, 3, 47.01, 80.0), Item(16, 3, 47.02, 80.0), Item(21, 3, 47.03, 0.0)});
  CHECK(landed.route.size() == 2);
}

TEST_CASE("route request: a plan that cannot be understood names its item") {
  const nlohmann::json good = Item(16, 3, 47.01, 80.0);
  CheckRefused("/plan/mission/items/1/frame", [&] {
    ParsePlan({good, Item(16, 10, 47.02, 80.0)});
  });
  CheckRefused("/plan/mission/items", [&] { ParsePlan({good}); });
  CheckRefused("/plan/mission/items/1/params", [&] {
    nlohmann::json bad = good;
    bad["params"] = {1, 2};
    ParsePlan({good, bad});
  });
  CheckRefused("/plan/mission", [] { ParseRouteRequest({{"plan", nlohmann::json::object()}}); });
  CHECK_FALSE(IsQgcPlan(Request()));
  CHECK(IsQgcPlan(Plan({good})));
}

TEST_CASE("route request: what of a plan is no route is left out and named") {
  const nlohmann::json good = Item(16, 3, 47.01, 80.0), more = Item(16, 3, 47.02, 80.0);
  for (const char* const kind : {"StructureScan", "CorridorCheese"}) {
    const RouteRequest request =
        ParsePlan({good, {{"type", "ComplexItem"}, {"complexItemType", kind}}, more});
    CHECK(request.route.size() == 2);
    REQUIRE(request.warnings.size() == 1);
    CHECK(request.warnings[0].starts_with(std::string("item 2 (") + kind + ") is left out"));
  }
  nlohmann::json nowhere = good;
  nowhere["params"][4] = nullptr;
  const RouteRequest request = ParsePlan({good, nowhere, more});
  CHECK(request.route.size() == 2);
  CHECK(request.warnings == std::vector<std::string>{"item 2 is left out: it has no place"});
  const nlohmann::json empty = {{"type", "ComplexItem"},
                                {"complexItemType", "CorridorScan"},
                                {"TransectStyleComplexItem", {{"Items", nlohmann::json::array()}}}};
  CHECK(ParsePlan({good, empty, more}).warnings.size() == 1);
  nlohmann::json above_ground = Item(16, 10, 47.03, 80.0);
  above_ground["AMSLAltAboveTerrain"] = 612.5;
  CHECK(ParsePlan({good, above_ground}).route.at(1).altitude_m == 612.5);
}

TEST_CASE("route request: a home without altitude matters only where heights count from it") {
  const auto parse = [](const nlohmann::json& home, int frame) {
    nlohmann::json plan = Plan({Item(16, frame, 47.01, 580.0), Item(16, frame, 47.02, 580.0)});
    plan["mission"]["plannedHomePosition"] = home;
    nlohmann::json object = Request();
    object.erase("route");
    object["plan"] = plan;
    return ParseRouteRequest(object);
  };
  for (const nlohmann::json& home :
       {nlohmann::json{47.0, 8.0, nullptr}, nlohmann::json{47.0, 8.0}}) {
    CHECK(parse(home, 0).route.size() == 2);
    CheckRefused("/plan/mission/plannedHomePosition", [&] { parse(home, 3); });
  }
  CheckRefused("/plan/mission/plannedHomePosition", [&] { parse({nullptr, nullptr, nullptr}, 0); });
}

TEST_CASE("route request: waypoints of Mission Planner are a plan") {
  const std::string text =
      "QGC WPL 110\r\n0\t1\t0\t16\t0\t0\t0\t0\t47.35\t8.45\t450\t1\r\n"
      "1\t0\t3\t16\t0\t0\t0\t0\t47.355\t8.46\t80\t1\r\n"
      "2\t0\t0\t16\t0\t0\t0\t0\t47.36\t8.47\t580\t1\r\n";
  const auto parse = [](const std::string& waypoints) {
    REQUIRE(IsWaypoints(waypoints));
    return ParseRouteRequest({{"plan", PlanOfWaypoints(waypoints)}, {"airspeed_mps", 15.0}});
  };
  const RouteRequest request = parse(text);
  REQUIRE(request.route.size() == 2);
  CHECK(request.route[0].altitude_m == 530.0);
  CHECK(request.route[1].altitude_m == 580.0);
  CHECK(request.route[1].longitude_deg == 8.47);
  CHECK(request.altitude_datum == "amsl");
  CHECK(request.airspeed_mps == 15.0);
  const std::string speeds =
      "3 0 0 178 1 9 0 0 0 0 0 1\r\n4 0 0 178 0 18 0 0 0 0 0 1\r\n5 0 0 178 0 20 0 0 0 0 0 1\r\n";
  CHECK(ParseRouteRequest({{"plan", PlanOfWaypoints(text + speeds)}}).airspeed_mps == 18.0);
  CheckRefused("/airspeed_mps", [&] { ParseRouteRequest({{"plan", PlanOfWaypoints(text)}}); });
  std::string blanks = "\xEF\xBB\xBF" + text;
  std::replace(blanks.begin(), blanks.end(), '\t', ' ');
  CHECK(parse(blanks).route.size() == 2);
  CheckRefused("line 3",
               [&] { PlanOfWaypoints("QGC WPL 110\n0 1 0 16 0 0 0 0 1 2 3 1\n1 0 3 16\n"); });
  CheckRefused("line 2", [] { PlanOfWaypoints("QGC WPL 110\n"); });
  // The home was never set.
  CheckRefused("/plan/mission/plannedHomePosition", [&] {
    parse("QGC WPL 110\n0 1 0 16 0 0 0 0 0 0 0 1\n1 0 3 16 0 0 0 0 47.1 8 80 1\n");
  });
  CHECK_FALSE(IsWaypoints("{}"));
}

}  // namespace
}  // namespace freelsd
