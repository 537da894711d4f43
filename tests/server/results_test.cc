// What is answered of stored sites, without the engine.
#include <doctest/doctest.h>

#include "tests/server/meadow.h"

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
  CHECK(approach["features"].size() == 3);
  CHECK(approach.contains("profile"));
  const double heading_deg = approach["plan"]["approach"]["heading_deg"];
  CHECK(heading_deg == doctest::Approx(270.0).epsilon(0.01));
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
