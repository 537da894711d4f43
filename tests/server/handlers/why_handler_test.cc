#include <doctest/doctest.h>

#include "tests/server/meadow.h"
#include "tests/server/openapi_check.h"
#include "tests/server/site_on_map.h"

namespace freelsd {
namespace {

constexpr char kWhy[] = "/v1/sites/f-r1/why?";

// A place by metres from the meadow's middle, as query parameters.
std::string At(double east_m, double north_m) {
  const GeoPoint place =
      LocalFrame(GeoPoint{47.0, 8.0, 400.0}).GeoFromWorld({east_m, north_m, 0.0});
  return "latitude_deg=" + std::to_string(place.latitude_deg) +
         "&longitude_deg=" + std::to_string(place.longitude_deg);
}

nlohmann::json Why(const MeadowServer& meadow, const std::string& query) {
  HoldAgainstContract(*meadow.client);
  return GetJson(*meadow.client, kWhy + query);
}

nlohmann::json RuleOf(const nlohmann::json& answer, const std::string& name) {
  for (const nlohmann::json& rule : answer["rules"]) {
    if (rule["rule"] == name) return rule;
  }
  return nullptr;
}

// The meadow with a pond, a house and a patch that nobody saw.
SiteMap MeadowWithHouse() {
  SiteMap meadow = Meadow();
  const auto cells = [](double west, double north, int side) {
    return cv::Rect(static_cast<int>(300 + west), static_cast<int>(300 - north), side, side);
  };
  meadow.layers.grass(cells(-40, 10, 10)).setTo(0.1f);
  meadow.map.upper(cells(30, 10, 8)).setTo(7.0f);
  for (cv::Mat1f* const layer : {&meadow.map.elevation, &meadow.map.upper}) {
    (*layer)(cells(-5, 60, 8)).setTo(std::nanf(""));
  }
  return meadow;
}

MeadowServer ServerWithHouse() {
  return MeadowServer([](Storage& storage) { PutOnMap(storage, MeadowSite(), MeadowWithHouse()); });
}

TEST_CASE("why not here: each place gets the planner's rule that it breaks, with numbers") {
  const MeadowServer meadow = ServerWithHouse();
  const nlohmann::json good = Why(meadow, At(10.5, -20.5) + "&wind_east_mps=0&wind_north_mps=-4");
  CAPTURE(good.dump());
  CHECK(good["verdict"] == "landable");
  CHECK(good["first_failed"].is_null());
  CHECK(good["evidence"]["height_m"].get<double>() == doctest::Approx(400.0).epsilon(1e-4));
  CHECK(good["evidence"]["height_sd_m"] == 0.102);
  CHECK(good["evidence"]["grass_probability"] == 0.988);
  CHECK(good["evidence"]["frames"].empty());
  CHECK(good["evidence"]["risk"].get<double>() > 0.0);
  CHECK(good["evidence"]["risk"].get<double>() < 0.05);
  const nlohmann::json pond = Why(meadow, At(-35.5, 5.5));
  CHECK(pond["verdict"] == "rejected");
  CHECK(pond["first_failed"] == "grass");
  CHECK(RuleOf(pond, "grass")["value"] == 0.098);
  CHECK(Why(meadow, At(34.5, 5.5))["first_failed"] == "object");
  CHECK(Why(meadow, At(-1.5, 56.5))["first_failed"] == "seen");
  CHECK(Why(meadow, At(0.5, 100.5))["first_failed"] == "outline");
  const nlohmann::json outside = Why(meadow, At(0, 400));
  CHECK(outside["first_failed"] == "seen");
  CHECK(outside["evidence"]["height_m"].is_null());
}

// The page's rule asked for touchdown_uncertainty_m alone.
TEST_CASE("why not here: a place that only the disc fits is refused, as the planner does") {
  const MeadowServer meadow = ServerWithHouse();
  const nlohmann::json near = Why(meadow, At(18.5, 5.5) + "&touchdown_uncertainty_m=10");
  const nlohmann::json rule = RuleOf(near, "hazard_distance");
  CAPTURE(near.dump());
  CHECK(rule["value"].get<double>() > 10.0);
  CHECK(rule["limit"].get<double>() > 12.0);
  CHECK_FALSE(rule["passed"]);
  CHECK(near["first_failed"] == "hazard_distance");
  CHECK(near["verdict"] == "rejected");
}

TEST_CASE("why not here: wind and aircraft of the request count") {
  const MeadowServer meadow = ServerWithHouse();
  CHECK(Why(meadow, At(10.5, -20.5) + "&wind=unknown")["first_failed"] == "wind_known");
  CHECK(Why(meadow, At(10.5, -20.5) + "&wind=unknown")["verdict"] == "unverified");
  const nlohmann::json storm = Why(meadow, At(10.5, -20.5) + "&wind_east_mps=30&wind_north_mps=0");
  CHECK(storm["first_failed"] == "wind");
  CHECK(storm["verdict"] == "rejected");
  const nlohmann::json loose = Why(meadow, At(10.5, -20.5) + "&max_slope_deg=30");
  CHECK(RuleOf(loose, "slope")["limit"] == 30.0);
  CHECK(loose["warnings"].size() == 1);
  // It needs more ground roll than the meadow has.
  const nlohmann::json fast =
      Why(meadow, At(10.5, -20.5) + "&ground_roll_m=500&wind_east_mps=0&wind_north_mps=-4");
  CHECK(fast["first_failed"] == "ground_roll");
}

TEST_CASE("why not here: the place of the planned touchdown has the plan's verdict") {
  const MeadowServer meadow = ServerWithHouse();
  for (const std::string wind :
       {"wind_east_mps=0&wind_north_mps=-4", "wind_east_mps=3&wind_north_mps=3", "wind=unknown"}) {
    CAPTURE(wind);
    const nlohmann::json approach = GetJson(*meadow.client, "/v1/sites/f-r1/approach?" + wind);
    const nlohmann::json at = approach["features"][2]["geometry"]["coordinates"];
    const nlohmann::json why =
        Why(meadow, "latitude_deg=" + at[1].dump() + "&longitude_deg=" + at[0].dump() + "&" + wind);
    CHECK(why["verdict"] == approach["verdict"]);
  }
}

TEST_CASE("why not here: a place that makes no sense is refused by name") {
  const MeadowServer meadow;
  const auto refused = [&](const std::string& query, int status, const std::string& code) {
    CAPTURE(query);
    const auto result = meadow.client->Get(kWhy + query);
    CheckProblem(result, status, code);
    return nlohmann::json::parse(result->body)["errors"][0]["pointer"];
  };
  CHECK(refused("longitude_deg=8", 400, "InvalidQuery") == "latitude_deg");
  CHECK(refused("latitude_deg=47", 400, "InvalidQuery") == "longitude_deg");
  CHECK(refused("latitude_deg=91&longitude_deg=8", 422, "InvalidValue") == "latitude_deg");
  CHECK(refused("latitude_deg=47&longitude_deg=181", 422, "InvalidValue") == "longitude_deg");
  CHECK(refused("latitude_deg=nan&longitude_deg=8", 400, "InvalidQuery") == "latitude_deg");
  CHECK(refused("latitude_deg=47&longitude_deg=8&place=x", 400, "UnknownParameter") == "place");
  CHECK(refused(At(0, 0) + "&max_bank_deg=95", 422, "InvalidValue") == "max_bank_deg");
  CheckProblem(meadow.client->Get("/v1/sites/f-r2/why?" + At(0, 0)), 409, "NoApproach");
  CheckProblem(meadow.client->Get("/v1/sites/f-r3/why?" + At(0, 0)), 404, "NoSuchSite");
}

TEST_CASE("headline numbers: strip, ground roll and tightest obstacle, and none for the flare") {
  const MeadowServer meadow = ServerWithHouse();
  HoldAgainstContract(*meadow.client);
  const nlohmann::json answer =
      GetJson(*meadow.client, "/v1/sites/f-r1/approach?wind_east_mps=0&wind_north_mps=-4");
  CAPTURE(answer["plan"].dump());
  const nlohmann::json& plan = answer["plan"];
  CHECK(plan["usable_length_m"].get<double>() > 100.0);
  CHECK(plan["usable_length_m"].get<double>() <= 600.0);
  CHECK(plan["usable_width_m"].get<double>() >= 16.0);
  const auto of_kind = [](const nlohmann::json& collection, const char* kind) {
    for (const nlohmann::json& feature : collection["features"]) {
      if (feature["properties"]["kind"] == kind) return feature;
    }
    return nlohmann::json();
  };
  const nlohmann::json roll = of_kind(answer, "ground_roll");
  REQUIRE_FALSE(roll.is_null());
  CHECK(roll["geometry"]["type"] == "Polygon");
  CHECK(roll["geometry"]["coordinates"][0].size() == 5);
  CHECK(roll["properties"]["length_m"].get<double>() <= plan["usable_length_m"].get<double>());
  CHECK(plan["approach"].contains("tightest_obstacle"));
  const nlohmann::json no_roll = GetJson(
      *meadow.client, "/v1/sites/f-r1/approach?ground_roll_m=0&wind_east_mps=0&wind_north_mps=-4");
  CHECK(of_kind(no_roll, "ground_roll").is_null());
  CHECK(plan["summary"].get<std::string>().find("least clearance") == std::string::npos);
  CHECK(plan["summary"].get<std::string>().find("usable strip of ") != std::string::npos);
}

}  // namespace
}  // namespace freelsd
