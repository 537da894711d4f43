// One plan per answer: what recall tells leads to the place it tells, and tells each place once.
#include <cmath>

#include <doctest/doctest.h>

#include "tests/server/recall/emergency_query.h"
#include "tests/server/site_on_map.h"

namespace freelsd {
namespace {

TEST_CASE("emergency: bearing and distance lead to the touchdown of the answer's own plan") {
  // The stored touchdown is far from where the plan lands.
  const auto elsewhere = [](Storage& storage) {
    SiteRow row = MeadowSite("amsl");
    row.latitude_deg += 0.0015;
    PutOnMap(storage, row, Meadow());
  };
  const MeadowServer meadow(elsewhere);
  for (const char* const wind : {"&wind_east_mps=3&wind_north_mps=0",
                                 "&wind_east_mps=0&wind_north_mps=-4",
                                 "&wind_east_mps=-3&wind_north_mps=3"}) {
    const nlohmann::json answer = GetJson(
        *meadow.client, Query(800.0, std::string(wind) + "&heading_deg=0&altitude_datum=amsl"));
    REQUIRE(answer["sites"].size() == 1);
    const nlohmann::json& site = answer["sites"][0];
    const nlohmann::json& touchdown = site["touchdown"];
    const GeoPoint place{touchdown["latitude_deg"], touchdown["longitude_deg"], 400.0};
    const Eigen::Vector3d way = LocalFrame({46.9955, 8.0, 400.0}).WorldFromGeo(place);
    CHECK(site["distance_m"].get<double>() == doctest::Approx(way.head<2>().norm()).epsilon(1e-4));
    const double off_deg =
        site["bearing_deg"].get<double>() - DegFromRad(std::atan2(way.x(), way.y()));
    CHECK(std::abs(std::remainder(off_deg, 360.0)) < 0.1);
    CHECK(site["bearing_deg"].get<double>() >= 0.0);
  }
}

TEST_CASE("emergency: the plan of the answer is what approach answers for its wind and aircraft") {
  const MeadowServer meadow(StoreAmslMeadow);
  for (const std::string wind : {"&wind_east_mps=3&wind_north_mps=1", ""}) {
    const nlohmann::json answer =
        GetJson(*meadow.client, Query(800.0, wind + "&heading_deg=0&altitude_datum=amsl"));
    REQUIRE(answer["sites"].size() == 1);
    const nlohmann::json& site = answer["sites"][0];
    std::string path =
        "/v1/sites/f-r1/approach?" + (wind.empty() ? "wind=unknown" : wind.substr(1));
    for (const auto& [name, value] : site["aircraft"].items()) {
      path += "&" + name + "=" + (value.is_string() ? value.get<std::string>() : value.dump());
    }
    const nlohmann::json plan = GetJson(*meadow.client, path)["plan"];
    for (const char* const key : {"heading_deg", "distance_m", "height_m", "loiter_radius_m"}) {
      CHECK(plan["approach"][key] == site["approach"][key]);
    }
    CHECK(plan["verdict"] == site["verdict"]);
    CHECK(site.contains("ground_speed_mps") == !wind.empty());
  }
  CheckProblem(meadow.client->Get("/v1/sites/f-r1/approach?wind=calm"), 400, "InvalidQuery");
  CheckProblem(meadow.client->Get("/v1/sites/f-r1/approach?wind=unknown&wind_east_mps=1"),
               400,
               "InvalidQuery");
}

TEST_CASE("emergency: wind that leaves no ground speed on final makes no site reachable") {
  const MeadowServer meadow(StoreAmslMeadow);
  const nlohmann::json aircraft{{"landing_airspeed_mps", 13.0},
                                {"crosswind_uncertainty_deg", 89.0}};
  const auto post = meadow.client->Post("/v1/emergency",
                                        nlohmann::json{{"latitude_deg", 46.9955},
                                                       {"longitude_deg", 8.0},
                                                       {"altitude_m", 1600.0},
                                                       {"wind_east_mps", 14.9},
                                                       {"wind_north_mps", 0},
                                                       {"heading_deg", 0},
                                                       {"altitude_datum", "amsl"},
                                                       {"aircraft", aircraft}}
                                            .dump(),
                                        "application/json");
  REQUIRE(post);
  REQUIRE(post->status == 200);
  CHECK(nlohmann::json::parse(post->body)["sites"].empty());
}

TEST_CASE("emergency: one place is told once, and a smaller limit begins like a larger one") {
  constexpr int kNumPlaces = 6;
  const MeadowServer meadow([](Storage& storage) {
    StoreAmslMeadow(storage);
    for (int i = 0; i < 2 * kNumPlaces; ++i) {
      // Each place twice, 6 m apart; the better scores are farther away.
      SiteRow row = MeadowSite("amsl", i % 2 == 0 ? 30.0 * i : 30.0 * (i - 1) + 6.0);
      row.id = "g-r" + std::to_string(i);
      row.flight_id = "g";
      row.recall->score = 0.3 + 0.05 * i;
      PutOnMap(storage, row, Meadow());
    }
  });
  const auto ids = [&](int limit) {
    const nlohmann::json answer = WholeAnswer(
        *meadow.client, Query(1200.0, kCalmNorth + ("&limit=" + std::to_string(limit))));
    std::vector<std::string> listed;
    for (const nlohmann::json& site : answer["sites"]) listed.push_back(site["site_id"]);
    return listed;
  };
  const std::vector<std::string> all = ids(50);
  CHECK(all.size() == kNumPlaces);
  for (int limit = 1; limit < kNumPlaces; ++limit) {
    CHECK(ids(limit) == std::vector<std::string>(all.begin(), all.begin() + limit));
  }
}

TEST_CASE("sites: lists and exports leave out what a later flight found otherwise") {
  const MeadowServer meadow([](Storage& storage) {
    SiteRow later = MeadowSite("amsl");
    later.id = std::string("g-r1");
    later.flight_id = std::string("g");
    later.feature_json = R"({"type":"Feature","geometry":null,"properties":{"id":"g-r1",)"
                         R"("verdict":"rejected","score":0.05}})";
    later.recall.reset();
    PutOnMap(storage, later, Meadow(), {{"f-r1", SupersededBy("g-r1")}});
  });
  httplib::Client& client = *meadow.client;
  const auto ids = [&client](const std::string& path) {
    std::string listed;
    const nlohmann::json sites = GetJson(client, path);
    for (const nlohmann::json& feature : sites["features"]) {
      listed += feature["properties"]["id"].get<std::string>() + " ";
    }
    return listed;
  };
  CHECK(ids("/v1/sites") == "f-r2 g-r1 ");
  CHECK(ids("/v1/sites?include=superseded") == "f-r1 f-r2 g-r1 ");
  CHECK(GetJson(client,
                "/v1/sites?include=superseded")["features"][0]["properties"]["superseded_by"] ==
        "g-r1");
  const nlohmann::json properties = GetJson(client, "/v1/sites/f-r1")["properties"];
  CHECK(properties["superseded_by"] == "g-r1");
  CHECK(properties["superseded_at"] == "2020-09-13T12:26:40Z");
  CHECK(properties["superseded_reason"] == "approach_blocked");
  CheckProblem(client.Get("/v1/sites?include=all"), 400, "InvalidQuery");
  for (const char* const format : {"plan", "waypoints", "rally", "cup", "kml", "csv"}) {
    const auto refused = client.Get(std::string("/v1/sites/f-r1?f=") + format);
    CheckProblem(refused, 409, "SiteRejected");
    CHECK(refused->body.find("g-r1") != std::string::npos);
  }
  CHECK(client.Get("/v1/sites/f-r1?f=csv&include=superseded")->status == 200);
}

}  // namespace
}  // namespace freelsd
