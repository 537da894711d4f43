// The landing of an emergency answer as a file for an autopilot.
#include <cmath>

#include <doctest/doctest.h>

#include "tests/api/export/sites/readers.h"
#include "tests/server/recall/emergency_query.h"

namespace freelsd {
namespace {

constexpr double kMaxPlaceErrorM = 0.05;
// QGroundControl measures on a sphere.
constexpr double kMaxHeadingErrorDeg = 0.1;

GeoPoint PlaceOf(const nlohmann::json& place) {
  return {place["latitude_deg"], place["longitude_deg"], place["altitude_m"]};
}

TEST_CASE("emergency landing: the plan leads to the best site as the answer plans it") {
  const MeadowServer meadow(StoreAmslMeadow);
  for (const std::string wind : {"&wind_east_mps=3&wind_north_mps=0",
                                 "&wind_east_mps=0&wind_north_mps=-4",
                                 "&wind_east_mps=-3&wind_north_mps=3"}) {
    const std::string query = Query(800.0, wind + "&heading_deg=0&altitude_datum=amsl");
    const nlohmann::json best = GetJson(*meadow.client, query)["sites"].at(0);
    const auto result = meadow.client->Get(query + "&f=plan&firmware=ardupilot");
    REQUIRE(result);
    INFO(result->body);
    REQUIRE(result->status == 200);
    const LandingPattern pattern = ReadPlan(result->body);
    CHECK(MetresBetween(pattern.land, PlaceOf(best["touchdown"])) < kMaxPlaceErrorM);
    CHECK(pattern.land.altitude_m ==
          doctest::Approx(best["touchdown"]["altitude_m"].get<double>()).epsilon(1e-6));
    CHECK(MetresBetween(pattern.loiter_center, PlaceOf(best["approach"]["loiter_center"])) <
          kMaxPlaceErrorM);
    CHECK(DegreesBetween(pattern.heading_deg, best["approach"]["heading_deg"]) <
          kMaxHeadingErrorDeg);
    const nlohmann::json plan = nlohmann::json::parse(result->body);
    CHECK(plan["mission"]["firmwareType"] == 3);
    CHECK(plan["mission"]["items"][0]["finalApproachSpeed"] ==
          best["aircraft"]["landing_airspeed_mps"]);
    CHECK(plan["freelsd"]["site_id"] == best["site_id"]);
    CHECK(plan["freelsd"]["verdict"] == best["verdict"]);
    CHECK(plan["freelsd"]["name"].get<std::string>().find("meadow 1") == 0);
  }
}

TEST_CASE("emergency landing: waypoints over the emergency listener and by POST") {
  const MeadowServer meadow(StoreAmslMeadow);
  const auto result = meadow.client->Get(Query(800.0, kCalmNorth) + std::string("&f=waypoints"));
  REQUIRE(result);
  REQUIRE(result->status == 200);
  const auto rows = SplitRows(result->body, '\t');
  CHECK(rows[0][0] == "QGC WPL 110");
  CHECK(rows[2][3] == "189");
  CHECK(rows[3][3] == "31");
  CHECK(rows[4][3] == "21");
  CHECK(result->get_header_value("Content-Disposition").find("waypoints") != std::string::npos);
  const nlohmann::json body{{"latitude_deg", 46.9955},
                            {"longitude_deg", 8.0},
                            {"altitude_m", 800.0},
                            {"altitude_datum", "amsl"},
                            {"heading_deg", 0.0},
                            {"wind_east_mps", 0.0},
                            {"wind_north_mps", 0.0}};
  const auto posted =
      meadow.client->Post("/v1/emergency?f=waypoints", body.dump(), "application/json");
  REQUIRE(posted);
  CHECK(posted->status == 200);
  CHECK(posted->body == result->body);
}

TEST_CASE("emergency landing: an unverified best site is called so in name, warnings and file") {
  // Unknown wind: at most unverified.
  const MeadowServer meadow(StoreAmslMeadow);
  const auto result = meadow.client->Get(Query(900.0, "&heading_deg=0&altitude_datum=amsl&f=plan"));
  REQUIRE(result);
  REQUIRE(result->status == 200);
  CHECK(result->get_header_value("Content-Disposition").find("emergency-UNVERIFIED.plan") !=
        std::string::npos);
  const nlohmann::json remarks = nlohmann::json::parse(result->body)["freelsd"];
  CHECK(remarks["name"] == "meadow 1 UNVERIFIED");
  CHECK(remarks["warnings"][0].get<std::string>().find("UNVERIFIED: ") == 0);
  CHECK(remarks["warnings"].dump().find("the wind is unknown") != std::string::npos);
}

TEST_CASE("emergency landing: without a site in reach or an altitude there is no file") {
  const MeadowServer meadow(StoreAmslMeadow);
  CheckProblem(meadow.client->Get("/v1/emergency?latitude_deg=-33&longitude_deg=-70&altitude_m=900"
                                  "&f=plan"),
               409,
               "NothingInReach");
  CheckProblem(meadow.client->Get(Query(800.0, "&f=kml")), 400, "InvalidQuery");
  CheckProblem(meadow.client->Get(Query(800.0, "&f=plan&firmware=x")), 400, "InvalidQuery");
  CheckProblem(meadow.client->Get(Query(800.0, "&f=plan&home_altitude_m=x")), 400, "InvalidQuery");
  const MeadowServer unknown;
  CheckProblem(unknown.client->Get(Query(1500.0, "&f=plan")), 409, "AltitudeUnknown");
  const auto above_home = unknown.client->Get(Query(1500.0, "&f=plan&home_altitude_m=390"));
  REQUIRE(above_home);
  REQUIRE(above_home->status == 200);
  CHECK(ReadPlan(above_home->body).land.altitude_m == doctest::Approx(10.0).epsilon(0.02));
}

}  // namespace
}  // namespace freelsd
