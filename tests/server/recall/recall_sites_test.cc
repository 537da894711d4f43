// Recall of stored sites: what can be reached gliding, and what is never promised.
#include <cmath>

#include <doctest/doctest.h>

#include "tests/server/child.h"
#include "tests/server/meadow.h"
#include "tests/server/recall/emergency_query.h"
#include "tests/server/site_on_map.h"

namespace freelsd {
namespace {

double MarginOf(httplib::Client& client, const std::string& path) {
  const nlohmann::json answer = GetJson(client, path);
  if (!answer["sites"].empty()) return answer["sites"][0]["arrival_margin_m"];
  REQUIRE(answer.contains("nearest_miss"));
  return answer["nearest_miss"]["arrival_margin_m"];
}

TEST_CASE("emergency: a site in reach is told with its approach, margin and time") {
  const MeadowServer meadow(StoreAmslMeadow);
  const nlohmann::json answer = GetJson(*meadow.client, Query(600.0, kCalmNorth));
  INFO(answer.dump());
  REQUIRE(answer["sites"].size() == 1);
  const nlohmann::json& site = answer["sites"][0];
  CHECK(site["site_id"] == "f-r1");
  CHECK(site["flight_id"] == "f");
  CHECK(site["rank"] == 1);
  CHECK(site["reachable"] == true);
  CHECK(site["verdict"] != "rejected");
  CHECK(site["distance_m"].get<double>() == doctest::Approx(500.0).epsilon(0.01));
  const double bearing_deg = site["bearing_deg"];
  CHECK(std::abs(std::remainder(bearing_deg, 360.0)) < 1.0);
  CHECK(site["arrival_margin_m"].get<double>() > 0.0);
  // 200 m above, no more than the straight glide of 500 m at 7 loses, less the final's height.
  CHECK(site["arrival_margin_m"].get<double>() < 200.0);
  CHECK(site["time_s"].get<double>() > 0.0);
  CHECK(site["age_s"].get<double>() > 0.0);
  CHECK(site["datum_penalty_m"] == 0.0);
  CHECK(site["touchdown"]["altitude_m"].get<double>() == doctest::Approx(400.0).epsilon(0.01));
  for (const char* key : {"heading_deg", "distance_m", "height_m", "start"}) {
    CHECK(site["approach"].contains(key));
  }
  CHECK_FALSE(answer.contains("nearest_miss"));
}

TEST_CASE("emergency: POST with the same JSON answers the same, age apart") {
  const MeadowServer meadow(StoreAmslMeadow);
  nlohmann::json got = GetJson(*meadow.client, Query(600.0, kCalmNorth));
  const auto result = meadow.client->Post("/v1/emergency",
                                          nlohmann::json{{"latitude_deg", 46.9955},
                                                         {"longitude_deg", 8.0},
                                                         {"altitude_m", 600.0},
                                                         {"wind_east_mps", 0},
                                                         {"wind_north_mps", 0},
                                                         {"heading_deg", 0},
                                                         {"altitude_datum", "amsl"},
                                                         {"aircraft", nullptr}}
                                              .dump(),
                                          "application/json");
  REQUIRE(result);
  REQUIRE(result->status == 200);
  nlohmann::json posted = nlohmann::json::parse(result->body);
  for (nlohmann::json* answer : {&got, &posted}) {
    (*answer)["sites"][0].erase("age_s");
    (*answer)["sites"][0].erase("score");
  }
  CHECK(got == posted);
  CHECK(meadow.client->Post(Query(600.0, kCalmNorth))->status == 200);
}

TEST_CASE("emergency: what cannot be reached is the nearest miss, and by how much") {
  const MeadowServer meadow(StoreAmslMeadow);
  const nlohmann::json answer = GetJson(*meadow.client, Query(430.0, kCalmNorth));
  CHECK(answer["sites"].empty());
  REQUIRE(answer.contains("nearest_miss"));
  const nlohmann::json& miss = answer["nearest_miss"];
  CHECK(miss["site_id"] == "f-r1");
  CHECK(miss["reachable"] == false);
  CHECK(miss["missing_m"].get<double>() > 0.0);
  CHECK(miss["missing_m"].get<double>() == -miss["arrival_margin_m"].get<double>());
}

TEST_CASE("emergency: unknown wind, heading or datum, and head wind, only ever cost margin") {
  const MeadowServer meadow(StoreAmslMeadow);
  httplib::Client& client = *meadow.client;
  const double known = MarginOf(client, Query(800.0, kCalmNorth));
  const std::string calm = "&wind_east_mps=0&wind_north_mps=0";
  CHECK(MarginOf(client, Query(800.0, calm + "&altitude_datum=amsl")) < known);
  CHECK(MarginOf(client, Query(800.0, "&heading_deg=0&altitude_datum=amsl")) < known);
  CHECK(MarginOf(client, Query(800.0, calm + "&heading_deg=180&altitude_datum=amsl")) < known);
  CHECK(MarginOf(client, Query(800.0, calm + "&heading_deg=0")) < known);
  CHECK(MarginOf(client,
                 Query(800.0,
                       "&wind_east_mps=0&wind_north_mps=-6&heading_deg=0"
                       "&altitude_datum=amsl")) < known);
  CHECK(MarginOf(client, Query(800.0, std::string(kCalmNorth) + "&glide_ratio=4")) < known);
}

TEST_CASE("emergency: every doubt about the answer is a warning") {
  const MeadowServer meadow;
  const nlohmann::json doubtful = GetJson(*meadow.client, Query(800.0))["warnings"];
  const std::string text = doubtful.dump();
  for (const char* word : {"datum", "wind", "heading", "terrain"}) {
    INFO(word);
    CHECK(text.find(word) != std::string::npos);
  }
}

TEST_CASE(
    "emergency: a rejected site is never among the sites, nor one without approach in this wind") {
  const MeadowServer meadow([](Storage& storage) {
    SiteRow rejected = MeadowSite("amsl");
    rejected.recall.reset();
    PutOnMap(storage, rejected, Meadow());
  });
  CHECK(GetJson(*meadow.client, Query(2000.0, kCalmNorth))["sites"].empty());
  const MeadowServer other(StoreAmslMeadow);
  const nlohmann::json storm = GetJson(
      *other.client,
      Query(3000.0, "&wind_east_mps=30&wind_north_mps=0&heading_deg=0&altitude_datum=amsl"));
  CHECK(storm["sites"].empty());
  CHECK(storm["summary"].get<std::string>().find("no approach in this wind") != std::string::npos);
}

TEST_CASE("emergency: terrain of a stored map on the way counts, also of a rejected site") {
  const auto with_wall = [](Storage& storage) {
    StoreAmslMeadow(storage);
    SiteMap wall = Meadow();
    // 250 m south of the meadow's middle, 300 m high.
    wall.map.upper(cv::Rect(0, 545, 600, 5)) = 300.0f;
    SiteRow row = MeadowSite("amsl");
    row.id = std::string("f-r9");
    row.recall.reset();
    PutOnMap(storage, row, wall);
  };
  const MeadowServer free(StoreAmslMeadow);
  const MeadowServer walled(with_wall);
  CHECK(GetJson(*free.client, Query(600.0, kCalmNorth))["sites"].size() == 1);
  const nlohmann::json answer = GetJson(*walled.client, Query(600.0, kCalmNorth));
  CHECK(answer["sites"].empty());
  CHECK(answer["nearest_miss"]["terrain_margin_m"].get<double>() < -100.0);
}

TEST_CASE("emergency: sites are ranked by margin, then verdict and score, up to the limit") {
  const MeadowServer meadow([](Storage& storage) {
    StoreAmslMeadow(storage);
    for (int i = 3; i < 8; ++i) {
      SiteRow row = MeadowSite("amsl", 40.0 * (i - 2));
      row.id = "f-r" + std::to_string(i);
      row.recall->score = 0.1 * i;
      row.updated_at_us = 1700000000000000;
      row.seen_at_us = row.updated_at_us;
      PutOnMap(storage, row, Meadow());
    }
  });
  const nlohmann::json answer =
      WholeAnswer(*meadow.client, Query(900.0, std::string(kCalmNorth) + "&limit=3"));
  REQUIRE(answer["sites"].size() == 3);
  for (size_t i = 0; i < 3; ++i) {
    CHECK(answer["sites"][i]["rank"] == i + 1);
    if (i == 0) continue;
    CHECK(answer["sites"][i - 1]["score"].get<double>() >=
          answer["sites"][i]["score"].get<double>());
  }
  CHECK(answer["sites"][0]["score"].get<double>() <
        answer["sites"][0]["score_when_stored"].get<double>());
}

TEST_CASE("emergency: bad parameters are named, with 400 or 422") {
  const MeadowServer meadow;
  httplib::Client& client = *meadow.client;
  CheckProblem(client.Get("/v1/emergency?latitude_deg=47&longitude_deg=8"), 422, "InvalidValue");
  CheckProblem(client.Get(Query(500.0, "&heading_deg=nan")), 400, "InvalidQuery");
  CheckProblem(client.Get(Query(500.0, "&colour=green")), 400, "UnknownParameter");
  CheckProblem(client.Get(Query(500.0, "&wind_east_mps=3")), 422, "InvalidValue");
  CheckProblem(client.Get(Query(500.0, "&aircraft=jumbo")), 422, "InvalidValue");
  CheckProblem(client.Get(Query(500.0, "&glide_ratio=0")), 422, "InvalidValue");
  CheckProblem(client.Get(Query(500.0, "&limit=0")), 422, "InvalidValue");
  CheckProblem(client.Get(Query(500.0, "&limit=1e1")), 422, "InvalidValue");
  CheckProblem(client.Get(Query(500.0, "&altitude_datum=msl")), 422, "InvalidValue");
  CheckProblem(client.Get(Query(1e300)), 422, "InvalidValue");
  CheckProblem(client.Post("/v1/emergency", R"({"latitude_deg":NaN})", ""), 400, "InvalidJson");
  CheckProblem(
      client.Post(
          "/v1/emergency", R"({"latitude_deg":47,"longitude_deg":8,"altitude_m":500,"x":1})", ""),
      422,
      "UnknownKey");
  CheckProblem(client.Delete("/v1/emergency"), 405, "MethodNotAllowed");
}

TEST_CASE("emergency: its listener has threads of its own and nothing else") {
  const MeadowServer meadow(StoreAmslMeadow, [](Config& config) {
    config.emergency = Address{"127.0.0.1", 0};
    config.num_http_threads = 2;
  });
  httplib::Client client = meadow.server->EmergencyClient();
  CheckProblem(client.Get("/v1/flights"), 404, "NotFound");
  CheckProblem(client.Get("/"), 404, "NotFound");
  // It would delay a recall.
  CheckProblem(
      client.Get("/v1/reach?latitude_deg=47&longitude_deg=8&altitude_m=600"), 404, "NotFound");
  // All of the main listener's threads wait for slow uploads.
  RawConnection first(meadow.server->port()), second(meadow.server->port());
  for (const RawConnection* slow : {&first, &second}) {
    slow->Send("POST /v1/flights HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100\r\n\r\n{");
  }
  const auto begin = std::chrono::steady_clock::now();
  CHECK(GetJson(client, Query(600.0, kCalmNorth))["sites"].size() == 1);
  CHECK(client.Get("/healthz")->status == 200);
  CHECK(std::chrono::steady_clock::now() - begin < std::chrono::seconds(4));
}

TEST_CASE("emergency: connections that say nothing, more than it has threads, do not silence it") {
  const MeadowServer meadow(StoreAmslMeadow, [](Config& config) {
    config.emergency = Address{"127.0.0.1", 0};
  });
  std::vector<std::unique_ptr<RawConnection>> silent;
  for (int i = 0; i < 40; ++i) {
    silent.push_back(std::make_unique<RawConnection>(meadow.server->emergency_port()));
    if (i % 2 == 0) silent.back()->Send("GET /v1/emergency HTTP/1.1\r\nHost: ");
  }
  httplib::Client client = meadow.server->EmergencyClient();
  const auto begin = std::chrono::steady_clock::now();
  CHECK(GetJson(client, Query(600.0, kCalmNorth))["sites"].size() == 1);
  CHECK(std::chrono::steady_clock::now() - begin < std::chrono::seconds(4));
}

TEST_CASE("emergency: the answer is the same after kill -9 and a cold start") {
  const TemporaryFolder folder;
  {
    Storage storage(StorageAt(folder.path() / "data"));
    StoreAmslMeadow(storage);
  }
  const auto ask = [&folder] {
    Child child({folder.path()});
    httplib::Client client = ClientOf(child.AwaitPort());
    nlohmann::json answer = GetJson(client, Query(600.0, kCalmNorth));
    CHECK(child.Stop(SIGKILL) == -SIGKILL);
    REQUIRE(answer["sites"].size() == 1);
    answer["sites"][0].erase("age_s");
    answer["sites"][0].erase("score");
    return answer;
  };
  const nlohmann::json first = ask();
  CHECK(ask() == first);
}

TEST_CASE("emergency: the nearest miss is found also far beyond reach") {
  const MeadowServer meadow(StoreAmslMeadow);
  const nlohmann::json answer = GetJson(
      *meadow.client,
      "/v1/emergency?latitude_deg=47.3&longitude_deg=8.0&altitude_m=600" + std::string(kCalmNorth));
  CHECK(answer["sites"].empty());
  REQUIRE(answer.contains("nearest_miss"));
  CHECK(answer["nearest_miss"]["distance_m"].get<double>() == doctest::Approx(33300).epsilon(0.01));
}

TEST_CASE("emergency: an area's sites are exported to preload an aircraft, none rejected") {
  const MeadowServer meadow(
      [](Storage& storage) {
        SiteRow site = MeadowSite("amsl");
        const Replan replan = ParseReplan(site.replan_json);
        const SiteMap map = Meadow();
        const StoredMapPlanner on_map(replan, replan.flight.aircraft, map);
        const Plan plan = on_map.planner.PlanFor(replan.request.wind_in_world);
        REQUIRE(plan.approach);
        const FlightContext context{"f", "amsl", LocalFrame(replan.origin)};
        site.approach_json = ApproachJson(plan, context).dump();
        PutOnMap(storage, site, map);
      },
      [](Config& config) {
        config.emergency = Address{"127.0.0.1", 0};
      });
  httplib::Client& client = *meadow.client;
  const std::string path = "/v1/emergency/export";
  const nlohmann::json all = GetJson(client, path);
  REQUIRE(all["features"].size() == 1);
  CHECK(all["features"][0]["properties"]["id"] == "f-r1");
  CHECK(GetJson(client, path + "?bbox=8.5,46,9.5,48")["features"].empty());
  const nlohmann::json plan = GetJson(client, path + "?f=plan&home_altitude_m=350");
  REQUIRE(plan["rallyPoints"]["points"].size() == 1);
  CHECK(plan["rallyPoints"]["points"][0][0].get<double>() == doctest::Approx(47.0));
  const auto rally = client.Get(path + "?f=rally&home_altitude_m=350");
  CHECK(rally->body.find("RALLY 47.0") != std::string::npos);
  CheckProblem(client.Get(path + "?f=rally"), 409, "AltitudeUnknown");
  CheckProblem(client.Get(path + "?f=kml"), 400, "InvalidQuery");
  CHECK(meadow.server->EmergencyClient().Get(path)->status == 200);
}

}  // namespace
}  // namespace freelsd
