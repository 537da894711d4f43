// What is answered of stored sites, without the engine.
#include <doctest/doctest.h>

#include "api/export/export.h"
#include "server/site_lookup.h"
#include "tests/server/test_server.h"

namespace freelsd {
namespace {

// A flat, grassy, wholly seen square of 600 m about the origin.
SiteMap Meadow() {
  constexpr int kNumCells = 600;
  SiteMap meadow;
  meadow.map.grid = {Eigen::Vector2d(-300, 300), 1.0, kNumCells, kNumCells};
  const cv::Size size(kNumCells, kNumCells);
  meadow.map.elevation = cv::Mat1f(size, 0.0f);
  meadow.map.upper = cv::Mat1f(size, 0.1f);
  meadow.map.standard_deviation = cv::Mat1f(size, 0.1f);
  meadow.map.num_points = cv::Mat1f(size, 9.0f);
  meadow.layers.grid = meadow.map.grid;
  meadow.layers.slope = cv::Mat1f(size, 0.0f);
  meadow.layers.roughness = cv::Mat1f(size, 0.0f);
  meadow.layers.grass = cv::Mat1f(size, 0.99f);
  meadow.layers.hazard = cv::Mat1b(size, uchar{0});
  meadow.layers.distance = cv::Mat1f(size, 100.0f);
  return meadow;
}

SiteRow MeadowSite() {
  Replan replan;
  replan.flight = ParseFlightRequest(R"({"name":"meadow","aircraft":{"profile":"small"}})");
  replan.origin = {47.0, 8.0, 400.0};
  replan.request.footprint = {{-60, -60}, {60, -60}, {60, 60}, {-60, 60}};
  replan.request.area_m2 = 14400.0;
  replan.request.grade = 1.0;
  replan.request.num_observations = 20;
  SiteRow site;
  site.id = std::string("f-r1");
  site.flight_id = std::string("f");
  site.region_id = 1;
  site.latitude_deg = 47.0;
  site.longitude_deg = 8.0;
  site.feature_json = R"({"type":"Feature","geometry":{"type":"Point","coordinates":[8,47,400]},)"
                      R"("properties":{"id":"f-r1","verdict":"unverified","score":0.5}})";
  site.replan_json = ReplanJson(replan);
  return site;
}

// A server whose folder already holds the meadow, and a site that never had a map.
struct MeadowServer {
  TemporaryFolder folder;
  std::unique_ptr<TestServer> server;
  std::unique_ptr<httplib::Client> client;

  MeadowServer() {
    {
      Storage storage(folder.path() / "data");
      storage.PutSite(MeadowSite(), SerializeSiteMap(Meadow()));
      SiteRow bare = MeadowSite();
      bare.id = "f-r2";
      bare.longitude_deg = 9.0;
      bare.feature_json =
          R"({"type":"Feature","geometry":{"type":"Point","coordinates":[9,47,400]},)"
          R"("properties":{"id":"f-r2","verdict":"rejected","score":0.1}})";
      storage.PutSite(bare, "");
    }
    server = std::make_unique<TestServer>(TestConfig(folder.path() / "data"));
    client = std::make_unique<httplib::Client>(server->Client());
  }
};

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

}  // namespace
}  // namespace freelsd
