// What is answered of stored sites, without the engine.
#include <cmath>

#include <doctest/doctest.h>

#include "api/export/layers/layers.h"
#include "tests/server/meadow.h"
#include "tests/server/site_on_map.h"

namespace freelsd {
namespace {

TEST_CASE("results: sites are ranked, cut by box and limit") {
  const MeadowServer meadow;
  const nlohmann::json all = GetJson(*meadow.client, "/v1/sites");
  REQUIRE(all["features"].size() == 2);
  CHECK(all["features"][0]["properties"]["id"] == "f-r1");
  CHECK(all["features"][0]["properties"]["rank"] == 1);
  CHECK(GetJson(*meadow.client, "/v1/sites?limit=1")["features"].size() == 1);
  CHECK(GetJson(*meadow.client, "/v1/sites?bbox=8.5,46,9.5,48")["features"].size() == 1);
  CHECK(GetJson(*meadow.client, "/v1/sites/f-r2")["properties"]["rank"] == 2);
}

TEST_CASE("results: an approach is planned anew for the wind and aircraft of the query") {
  const MeadowServer meadow;
  CheckProblem(meadow.client->Get("/v1/sites/f-r1/approach"), 409, "NoApproach");
  // Air moves to the east: the final is flown to the west.
  const nlohmann::json approach = GetJson(
      *meadow.client, "/v1/sites/f-r1/approach?wind_east_mps=3&wind_north_mps=0&max_bank_deg=35");
  CHECK(approach["features"].size() == 5);
  CHECK(approach.contains("profile"));
  const double heading_deg = approach["plan"]["approach"]["heading_deg"];
  CHECK(heading_deg == doctest::Approx(270.0).epsilon(0.01));
}

TEST_CASE("results: the go-around is told with the approach, planned anew, and in recall") {
  const MeadowServer meadow;
  const auto go_around = [&meadow](const std::string& more) {
    const nlohmann::json approach =
        GetJson(*meadow.client, "/v1/sites/f-r1/approach?wind_east_mps=0&wind_north_mps=-4" + more);
    nlohmann::json feature = approach["features"].back();
    REQUIRE(feature["properties"]["kind"] == "go_around");
    CHECK(feature["properties"]["no_return_distance_m"] ==
          approach["plan"]["approach"]["no_return_distance_m"]);
    CHECK(approach["features"][0]["properties"]["no_return_distance_m"] ==
          feature["properties"]["no_return_distance_m"]);
    return feature;
  };
  const nlohmann::json told = go_around("");
  // Free ground: it begins 2 m up, the safety margin, outside the map's own 0.1 m.
  const nlohmann::json& line = told["geometry"]["coordinates"];
  REQUIRE(line.size() == 2);
  CHECK(line[0][2].get<double>() == doctest::Approx(402.1).epsilon(1e-3));
  CHECK(line[1][2].get<double>() >= 410.0 - 1e-3);
  CHECK(line[1][1] > line[0][1]);
  CHECK(told["properties"]["climb_angle_deg"] == 5.0);
  CHECK(told["properties"]["unseen_ratio"].get<double>() < 0.05);
  CHECK(go_around("&climb_gradient_deg=20")["properties"]["climb_angle_deg"] == 20.0);
  CheckProblem(
      meadow.client->Get("/v1/sites/f-r1/approach?climb_gradient_deg=60"), 422, "InvalidValue");
  const nlohmann::json info = GetJson(*meadow.client, "/v1/info");
  CHECK(info["aircraft_profiles"]["small"]["climb_gradient_deg"] == 5.0);
  const nlohmann::json recall =
      GetJson(*meadow.client,
              "/v1/emergency?latitude_deg=46.9955&longitude_deg=8&altitude_m=800&heading_deg=0"
              "&wind_east_mps=0&wind_north_mps=-4");
  REQUIRE(recall["sites"].size() == 1);
  CHECK(recall["sites"][0]["approach"]["no_return_distance_m"].get<double>() >= 8.0);
}

// The whole map but a strip about the touchdown is a wood that no climb clears.
SiteMap Clearing() {
  SiteMap map = Meadow();
  map.map.upper.rowRange(0, 120) = 90.0f;
  return map;
}

TEST_CASE("results: where no climb clears there is no go-around, and no point of no return") {
  const MeadowServer meadow([](Storage& storage) { PutOnMap(storage, MeadowSite(), Clearing()); });
  const nlohmann::json approach =
      GetJson(*meadow.client, "/v1/sites/f-r1/approach?wind_east_mps=0&wind_north_mps=-4");
  for (const nlohmann::json& feature : approach["features"]) {
    CHECK(feature["properties"]["kind"] != "go_around");
  }
  CHECK(approach["plan"]["verdict"] == "landable");
  CHECK(approach["plan"]["approach"]["no_return_distance_m"].is_null());
}

TEST_CASE("results: every list tells when the ground was photographed, never the row's age") {
  constexpr int64_t kDayUs = 86400000000;
  const int64_t now_us = NowUs();
  const MeadowServer meadow([now_us](Storage& storage) {
    SiteRow site = MeadowSite("amsl");
    site.seen_at_us = now_us - 9 * kDayUs;
    site.confirmed_at_us = now_us - 3 * kDayUs;
    // The age of the row is not the ground's.
    site.updated_at_us = now_us;
    PutOnMap(storage, site, Meadow());
  });
  const std::string seen_at = Rfc3339(now_us - 3 * kDayUs);
  const std::string near = "latitude_deg=46.9955&longitude_deg=8&altitude_m=800&heading_deg=0";
  const std::vector<nlohmann::json> told{
      GetJson(*meadow.client, "/v1/sites")["features"][0]["properties"],
      GetJson(*meadow.client, "/v1/sites?order=new_look")["features"][0]["properties"],
      GetJson(*meadow.client, "/v1/sites/f-r1")["properties"],
      GetJson(*meadow.client, "/v1/emergency/export")["features"][0]["properties"],
      GetJson(*meadow.client, "/v1/emergency?" + near)["sites"][0]};
  for (const nlohmann::json& site : told) {
    CAPTURE(site.dump());
    CHECK(site["last_seen_at"] == seen_at);
    CHECK(std::abs(site["age_s"].get<double>() - 3.0 * 86400.0) < 60.0);
  }
}

TEST_CASE("results: a wind or an aircraft that makes no sense is refused by name") {
  const MeadowServer meadow;
  const std::string path = "/v1/sites/f-r1/approach?";
  CheckProblem(
      meadow.client->Get(path + "wind_east_mps=nan&wind_north_mps=0"), 400, "InvalidQuery");
  CheckProblem(meadow.client->Get(path + "wind_east_mps=1"), 400, "InvalidQuery");
  CheckProblem(meadow.client->Get(path + "max_bank_deg=95"), 422, "InvalidValue");
  CheckProblem(meadow.client->Get(path + "wind_east_mps=60&wind_north_mps=0"), 409, "NoApproach");
  CheckProblem(meadow.client->Get("/v1/sites/f-r2/approach?wind_east_mps=1&wind_north_mps=1"),
               409,
               "NoApproach");
}

TEST_CASE("results: a wind rose says of each wind what an approach for it says") {
  const MeadowServer meadow;
  const nlohmann::json rose =
      GetJson(*meadow.client, "/v1/sites/f-r1/wind-rose?directions=4&speeds_mps=0,3,60");
  CHECK(rose["directions_deg"] == nlohmann::json{0.0, 90.0, 180.0, 270.0});
  CHECK(rose["speeds_mps"] == nlohmann::json{0.0, 3.0, 60.0});
  CHECK(rose["aircraft"]["profile"] == "small");
  REQUIRE(rose["entries"].size() == 12);
  // From the east: the air moves west, the final is flown to the east.
  const nlohmann::json from_east = rose["entries"][5];
  CHECK(from_east["wind_from_deg"] == 90.0);
  CHECK(from_east["wind_speed_mps"] == 3.0);
  CHECK(from_east["heading_deg"] == doctest::Approx(90.0).epsilon(0.01));
  const nlohmann::json approach =
      GetJson(*meadow.client, "/v1/sites/f-r1/approach?wind_east_mps=-3&wind_north_mps=0");
  const nlohmann::json& plan = approach["plan"];
  CHECK(from_east["verdict"] == plan["verdict"]);
  CHECK(from_east["verdict"] == "landable");
  CHECK(from_east["reject_reason"].is_null());
  CHECK(from_east["unseen_ratio"] == plan["unseen_ratio"]);
  for (const char* const name : {"heading_deg", "height_m", "crosswind_mps", "min_clearance_m"}) {
    CHECK(from_east[name] == plan["approach"][name]);
  }
  const nlohmann::json& touchdown = approach["features"][2]["geometry"]["coordinates"];
  CHECK(from_east["touchdown"]["longitude_deg"] == touchdown[0]);
  CHECK(from_east["touchdown"]["latitude_deg"] == touchdown[1]);
  for (int i = 8; i < 12; ++i) {
    const nlohmann::json& too_strong = rose["entries"][static_cast<size_t>(i)];
    CHECK(too_strong["verdict"] == "rejected");
    CHECK(too_strong["reject_reason"] == "wind_too_strong");
    CHECK(too_strong["heading_deg"].is_null());
    CHECK(too_strong["touchdown"].is_null());
  }
}

TEST_CASE("results: a wind rose is for the aircraft of the query, by itself of 36 by 4 winds") {
  const MeadowServer meadow;
  const nlohmann::json rose = GetJson(*meadow.client, "/v1/sites/f-r1/wind-rose");
  CHECK(rose["entries"].size() == 144);
  CHECK(rose["entries"][37]["wind_from_deg"] == 10.0);
  CHECK(rose["entries"][37]["wind_speed_mps"] == 5.0);
  const nlohmann::json slow =
      GetJson(*meadow.client,
              "/v1/sites/f-r1/"
              "wind-rose?directions=1&speeds_mps=4.8,5&landing_airspeed_mps=8&max_slope_deg=30");
  CHECK(slow["aircraft"]["landing_airspeed_mps"] == 8.0);
  CHECK(slow["warnings"].size() == 1);
  // 8 m/s descending at 8 degrees are 7.92 m/s over ground in calm; at least 3 must be left.
  CHECK_FALSE(slow["entries"][0]["reject_reason"] == "wind_too_strong");
  CHECK(slow["entries"][1]["reject_reason"] == "wind_too_strong");
}

TEST_CASE("results: a wind rose of winds that make no sense, or of too many, is refused by name") {
  const MeadowServer meadow;
  const auto refused = [&](const std::string& query, int status, const std::string& code) {
    CAPTURE(query);
    const auto result = meadow.client->Get("/v1/sites/f-r1/wind-rose?" + query);
    CheckProblem(result, status, code);
    return nlohmann::json::parse(result->body);
  };
  CHECK(refused("directions=x", 400, "InvalidQuery")["errors"][0]["pointer"] == "directions");
  CHECK(refused("directions=0", 422, "InvalidValue")["errors"][0]["pointer"] == "directions");
  refused("directions=7.5", 422, "InvalidValue");
  refused("directions=1e1", 422, "InvalidValue");
  refused("directions=181", 422, "InvalidValue");
  CHECK(refused("speeds_mps=", 400, "InvalidQuery")["errors"][0]["pointer"] == "speeds_mps");
  refused("speeds_mps=1,,2", 400, "InvalidQuery");
  refused("speeds_mps=1,nan", 400, "InvalidQuery");
  refused("speeds_mps=5,2.5", 422, "InvalidValue");
  refused("speeds_mps=-1", 422, "InvalidValue");
  CHECK(refused("speeds_mps=101", 422, "InvalidValue")["errors"][0]["pointer"] == "speeds_mps");
  const nlohmann::json too_many = refused("directions=180&speeds_mps=1,2,3", 422, "InvalidValue");
  CHECK(too_many["limit"] == GetJson(*meadow.client, "/v1/info")["limits"]["max_num_rose_winds"]);
  CHECK(too_many["observed"] == 540);
  refused("max_bank_deg=95", 422, "InvalidValue");
  refused("wind_east_mps=1", 400, "UnknownParameter");
  CheckProblem(meadow.client->Get("/v1/sites/f-r2/wind-rose"), 409, "NoApproach");
  CheckProblem(meadow.client->Get("/v1/sites/f-r3/wind-rose"), 404, "NoSuchSite");
}

TEST_CASE("results: layers are listed and drawn, or told to be missing") {
  const MeadowServer meadow;
  CHECK(GetJson(*meadow.client, "/v1/sites/f-r1/layers")["layers"].size() == LayerNames().size());
  const auto png = meadow.client->Get("/v1/sites/f-r1/layers/hazard.png");
  CHECK(png->get_header_value("Content-Type") == "image/png");
  CHECK(png->body.substr(1, 3) == "PNG");
  CHECK(meadow.client->Get("/v1/sites/f-r1/layers/slope/legend.png")->body.substr(1, 3) == "PNG");
  CHECK(meadow.client->Get("/v1/sites/f-r1/layers/elevation.tif")->body.substr(0, 2) == "II");
  CheckProblem(meadow.client->Get("/v1/sites/f-r1/layers/colour.png"), 404, "NoSuchLayer");
  CHECK(GetJson(*meadow.client, "/v1/sites/f-r2/layers")["layers"].empty());
  CheckProblem(meadow.client->Get("/v1/sites/f-r2/layers/hazard.png"), 404, "NoMap");
}

TEST_CASE("results: a deleted site is gone, others stay") {
  const MeadowServer meadow;
  CHECK(meadow.client->Delete("/v1/sites/f-r2")->status == 204);
  CheckProblem(meadow.client->Get("/v1/sites/f-r2"), 404, "NoSuchSite");
  CHECK(GetJson(*meadow.client, "/v1/sites")["features"].size() == 1);
}

TEST_CASE("results: regions and their history of a flight without any are empty or missing") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  CHECK(GetJson(fresh.client, "/v1/flights/" + flight + "/regions")["features"].empty());
  CHECK(GetJson(fresh.client, "/v1/flights/" + flight + "/sites")["features"].empty());
  CheckProblem(
      fresh.client.Get("/v1/flights/" + flight + "/regions/1/history"), 404, "NoSuchRegion");
}

TEST_CASE("results: a finished flight without a site says why") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  for (int i = 0; i < 3; ++i) {
    REQUIRE(PutFrame(fresh.client, flight, std::to_string(i), NoiseImage(i), SomeMeta(i))->status ==
            201);
  }
  const auto job = fresh.client.Post("/v1/flights/" + flight + "/finish");
  REQUIRE(job->status == 202);
  CHECK(AwaitJob(fresh.client, nlohmann::json::parse(job->body)["id"])["state"] == "done");
  const nlohmann::json warnings = GetJson(fresh.client, "/v1/flights/" + flight)["warnings"];
  CAPTURE(warnings.dump());
  CHECK(warnings.dump().find("no sites: none of the ") != std::string::npos);
}

}  // namespace
}  // namespace freelsd
