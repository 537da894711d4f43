// Which legs to fly next, over HTTP.
#include <doctest/doctest.h>

#include "tests/server/meadow_map.h"
#include "tests/server/openapi_check.h"

namespace freelsd {
namespace {

const std::string kLook = "/v1/flights/f/next-look";

// The meadow, of which nobody saw what lies east of a line.
SiteMap MeadowSeenWestOf(int col) {
  SiteMap meadow = Meadow();
  const cv::Rect unseen(col, 0, meadow.map.grid.num_cols - col, meadow.map.grid.num_rows);
  for (cv::Mat1f* const raster : {&meadow.map.elevation,
                                  &meadow.map.upper,
                                  &meadow.map.num_points,
                                  &meadow.layers.slope,
                                  &meadow.layers.roughness}) {
    (*raster)(unseen).setTo(std::nanf(""));
  }
  meadow.layers.hazard(unseen).setTo(kUnseen);
  return meadow;
}

MeadowServer HalfSeenServer() {
  return MeadowServer([](Storage& storage) { StoreMeadowMap(storage, MeadowSeenWestOf(330)); });
}

// Metres east of the meadow's middle.
double EastOf(const nlohmann::json& position) {
  const GeoPoint place{position[1], position[0], 400.0};
  return LocalFrame(GeoPoint{47.0, 8.0, 400.0}).WorldFromGeo(place).x();
}

nlohmann::json ProblemOf(const MeadowServer& meadow, const std::string& path, int status) {
  const auto answer = meadow.client->Get(path);
  REQUIRE(answer);
  CHECK(answer->status == status);
  CHECK(answer->get_header_value("Content-Type") == "application/problem+json");
  return nlohmann::json::parse(answer->body);
}

TEST_CASE("next look: legs over what nobody saw, with their places and gains") {
  const MeadowServer meadow = HalfSeenServer();
  HoldAgainstContract(*meadow.client);
  const nlohmann::json look = GetJson(*meadow.client, kLook);
  REQUIRE(look["features"].size() == 2);
  CHECK(look["altitude_datum"] == "amsl");
  CHECK(look["landing_value"] == 0.5);  // the meadow's site is unverified
  double sum = 0.0;
  for (const nlohmann::json& leg : look["features"]) {
    CHECK(leg["geometry"]["type"] == "LineString");
    REQUIRE(leg["geometry"]["coordinates"].size() == 2);
    CHECK(EastOf(leg["geometry"]["coordinates"][0]) + EastOf(leg["geometry"]["coordinates"][1]) >
          0.0);
    const nlohmann::json& properties = leg["properties"];
    CHECK(properties["expected_gain"] > 0.5);
    CHECK_FALSE(properties["places"].empty());
    sum += properties["expected_gain"].get<double>();
  }
  CHECK(look["expected_gain"].get<double>() == doctest::Approx(sum).epsilon(0.01));
  CHECK(GetJson(*meadow.client, kLook + "?legs=1&f=geojson")["features"].size() == 1);
}

TEST_CASE("next look: a plan of QGroundControl flies the same legs, one survey each") {
  const MeadowServer meadow = HalfSeenServer();
  HoldAgainstContract(*meadow.client);
  const nlohmann::json legs = GetJson(*meadow.client, kLook)["features"];
  const auto answer = meadow.client->Get(kLook + "?f=plan");
  REQUIRE(answer->status == 200);
  CHECK(answer->get_header_value("Content-Type") == "application/vnd.qgroundcontrol.plan+json");
  const nlohmann::json plan = nlohmann::json::parse(answer->body);
  CHECK(plan["fileType"] == "Plan");
  const nlohmann::json& items = plan["mission"]["items"];
  REQUIRE(items.size() == legs.size());
  for (size_t i = 0; i < items.size(); ++i) {
    const nlohmann::json& flown = items[i]["TransectStyleComplexItem"]["Items"];
    // Leading in, start, trigger, end, trigger, leading out.
    REQUIRE(flown.size() == 6);
    const nlohmann::json& line = legs[i]["geometry"]["coordinates"];
    CHECK(flown[1]["params"][4].get<double>() ==
          doctest::Approx(line[0][1].get<double>()).epsilon(1e-8));
    CHECK(flown[1]["params"][5].get<double>() ==
          doctest::Approx(line[0][0].get<double>()).epsilon(1e-8));
    CHECK(flown[3]["params"][4].get<double>() ==
          doctest::Approx(line[1][1].get<double>()).epsilon(1e-8));
    CHECK(flown[1]["params"][6].get<double>() ==
          doctest::Approx(legs[i]["properties"]["altitude_m"].get<double>()).epsilon(1e-4));
    CHECK(flown[2]["command"] == 206);
    CHECK(flown[2]["params"][0] > 0.0);
    CHECK(flown[4]["params"][0] == 0.0);
  }
  const nlohmann::json above_home =
      nlohmann::json::parse(meadow.client->Get(kLook + "?f=plan&home_altitude_m=380")->body);
  const nlohmann::json& first = above_home["mission"]["items"][0]["TransectStyleComplexItem"];
  CHECK(first["Items"][1]["frame"] == 3);
  CHECK(first["Items"][1]["params"][6].get<double>() ==
        doctest::Approx(legs[0]["properties"]["altitude_m"].get<double>() - 380.0).epsilon(1e-3));
}

TEST_CASE("next look: the answer follows the flight's newest map") {
  const MeadowServer meadow = MeadowServer([](Storage& storage) {
    // An earlier evaluation of the flight saw the west only, the map in force nearly all.
    const FlightMapRow earlier = StageMeadowMap(storage, MeadowSeenWestOf(330));
    storage.sites.PutEvaluation({{SiteOnMap(earlier)}, {}, {earlier.id}, {}}, {});
    const FlightMapRow later = StageMeadowMap(storage, MeadowSeenWestOf(560));
    storage.sites.PutEvaluation({{SiteOnMap(later)}, {}, {later.id}, {earlier.id}}, {});
  });
  const nlohmann::json later = GetJson(*meadow.client, kLook + "?legs=1");
  const nlohmann::json before = GetJson(*HalfSeenServer().client, kLook + "?legs=1");
  const auto middle_east = [](const nlohmann::json& look) {
    const nlohmann::json& line = look["features"][0]["geometry"]["coordinates"];
    return 0.5 * (EastOf(line[0]) + EastOf(line[1]));
  };
  // What is seen now is not looked at again.
  CHECK((later["features"] == before["features"]) == false);
  CHECK(std::abs(middle_east(later)) > std::abs(middle_east(before)) + 20.0);
}

TEST_CASE("next look: what cannot be answered is said") {
  const MeadowServer meadow = HalfSeenServer();
  HoldAgainstContract(*meadow.client);
  CHECK(meadow.client->Post("/v1/flights", R"({"name": "new"})", "application/json")->status ==
        201);
  const nlohmann::json flights = GetJson(*meadow.client, "/v1/flights");
  std::string flight;
  for (const nlohmann::json& each : flights["flights"]) {
    if (each["name"] == "new") flight = each["id"];
  }
  REQUIRE_FALSE(flight.empty());
  const nlohmann::json no_map = ProblemOf(meadow, "/v1/flights/" + flight + "/next-look", 409);
  CHECK(no_map["code"] == "NoMapYet");
  CHECK(no_map["detail"].get<std::string>().find("no map yet") != std::string::npos);
  CHECK(ProblemOf(meadow, "/v1/flights/none/next-look", 404)["code"] == "NoSuchFlight");
  for (const char* const legs : {"0", "9", "-1", "1.5"}) {
    CAPTURE(legs);
    CHECK(ProblemOf(meadow, kLook + "?legs=" + legs, 422)["errors"][0]["pointer"] == "legs");
  }
  CHECK(ProblemOf(meadow, kLook + "?legs=two", 400)["errors"][0]["pointer"] == "legs");
  CHECK(ProblemOf(meadow, kLook + "?f=kml", 400)["errors"][0]["pointer"] == "f");
  CHECK(ProblemOf(meadow, kLook + "?leg=1", 400)["code"] == "UnknownParameter");
}

}  // namespace
}  // namespace freelsd
