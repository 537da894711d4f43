// Sites in other formats, over HTTP.
#include <algorithm>

#include <doctest/doctest.h>

#include "server/handlers/lookups.h"
#include "tests/api/export/layers/hill_map.h"
#include "tests/api/export/sites/readers.h"
#include "tests/api/export/sites/sites.h"
#include "tests/server/site_on_map.h"
#include "tests/server/test_server.h"

namespace freelsd {
namespace {

constexpr int64_t kSeenAtUs = 1600000000000000;

// As stored: landable (with a map), unverified and rejected, of a flight of this datum.
struct SitesServer {
  TemporaryFolder folder;
  std::unique_ptr<TestServer> server;
  std::unique_ptr<httplib::Client> client;

  explicit SitesServer(const std::function<void(Replan&)>& change) : SitesServer("amsl", change) {}
  explicit SitesServer(const std::string& datum = "amsl",
                       const std::function<void(Replan&)>& change = {}) {
    {
      Storage storage(StorageAt(folder.path() / "data"));
      FlightRow flight;
      flight.id = "f1";
      flight.name = "meadows";
      flight.request_json = RequestOf(datum).canonical_json;
      storage.flights.Insert(flight);
      Put(storage, Verdict::kLandable, 1, datum, HillMap(), change);
      Put(storage, Verdict::kUnverified, 2, datum, std::nullopt);
      Put(storage, Verdict::kRejected, 3, datum, std::nullopt);
    }
    server = std::make_unique<TestServer>(TestConfig(folder.path() / "data"));
    client = std::make_unique<httplib::Client>(server->Client());
  }

  static FlightRequest RequestOf(const std::string& datum) {
    return ParseFlightRequest(R"({"name":"meadows","altitude_datum":")" + datum + "\"}");
  }
  static void Put(Storage& storage,
                  Verdict verdict,
                  int region_id,
                  const std::string& datum,
                  const std::optional<SiteMap>& map,
                  const std::function<void(Replan&)>& change = {}) {
    KnownSiteOptions options;
    options.verdict = verdict;
    options.region_id = region_id;
    options.altitude_datum = datum;
    const KnownSite known = MakeSite(options);
    Replan replan;
    replan.flight = RequestOf(datum);
    replan.origin = options.origin;
    replan.request.footprint = {{0, 0}, {20, 0}, {20, 20}, {0, 20}};
    if (change) change(replan);
    SiteRow row;
    row.id = "f1-r" + std::to_string(region_id);
    row.flight_id = std::string("f1");
    row.region_id = region_id;
    row.latitude_deg = known.touchdown.latitude_deg;
    row.longitude_deg = known.touchdown.longitude_deg;
    row.feature_json = known.feature_json;
    row.approach_json = known.approach_json;
    row.replan_json = ReplanJson(replan);
    row.seen_at_us = kSeenAtUs;
    if (map) {
      PutOnMap(storage, row, *map);
    } else {
      PutWithoutMap(storage, row);
    }
  }
};

std::string TypeOf(const httplib::Result& result) {
  REQUIRE(result);
  CHECK(result->status == 200);
  return result->get_header_value("Content-Type");
}

TEST_CASE("export: every format by name, for a site and for a flight") {
  const SitesServer sites;
  for (const SiteFormat& format : SiteFormats()) {
    const std::string query = "?home_altitude_m=400&f=" + std::string(format.name);
    for (const char* const path : {"/v1/sites/f1-r1", "/v1/flights/f1/sites"}) {
      const auto result = sites.client->Get(path + query);
      CHECK(TypeOf(result) == format.media_type);
      CHECK(result->get_header_value("Content-Disposition").find("attachment") == 0);
      CHECK(!result->body.empty());
    }
  }
  CHECK(TypeOf(sites.client->Get("/v1/sites/f1-r1?f=geojson")) == "application/geo+json");
  CHECK(TypeOf(sites.client->Get("/v1/flights/f1/sites?f=geojson")) == "application/geo+json");
}

TEST_CASE("export: Accept chooses too, by its weights, what is not known is answered in GeoJSON") {
  const SitesServer sites;
  const auto type = [&sites](const std::string& accept) {
    return TypeOf(sites.client->Get("/v1/sites/f1-r1", {{"Accept", accept}}));
  };
  CHECK(type("text/csv") == "text/csv");
  CHECK(type("text/csv;q=0.2, application/vnd.google-earth.kml+xml;q=0.9") ==
        "application/vnd.google-earth.kml+xml");
  CHECK(type("*/*") == "application/geo+json");
  CHECK(type("application/json, text/csv;q=0.5") == "application/geo+json");
  CHECK(type("text/csv;q=0") == "application/geo+json");
  CHECK(type("image/x-unknown") == "application/geo+json");
  CHECK(type("text/html,application/xhtml+xml,*/*;q=0.8") == "text/html; charset=utf-8");
}

TEST_CASE("export: the report is one page with a policy that lets it ask for nothing") {
  const SitesServer sites;
  const auto report = sites.client->Get("/v1/sites/f1-r1?f=html");
  CHECK(TypeOf(report) == "text/html; charset=utf-8");
  CHECK(report->get_header_value("Content-Security-Policy").find("default-src 'none'") == 0);
  CHECK(report->body.find("data:image/png") != std::string::npos);
  CHECK(TypeOf(sites.client->Get("/v1/sites/f1-r3?f=html")) == "text/html; charset=utf-8");
}

TEST_CASE("export: a rejected site is refused where something would fly to it") {
  const SitesServer sites;
  for (const char* const format : {"plan", "waypoints", "rally", "cup"}) {
    const std::string query = "?home_altitude_m=400&f=" + std::string(format);
    const auto refused = sites.client->Get("/v1/sites/f1-r3" + query);
    CheckProblem(refused, 409, "SiteRejected");
    CHECK(refused->body.find("Rejected (") != std::string::npos);
    const auto flight = sites.client->Get("/v1/flights/f1/sites" + query);
    CHECK(flight->status == 200);
    CHECK(flight->body.find("f1-r3") == std::string::npos);
  }
  CHECK(sites.client->Get("/v1/sites/f1-r2?f=plan")
            ->get_header_value("Content-Disposition")
            .find("f1-r2-UNVERIFIED.plan") != std::string::npos);
}

TEST_CASE("export: waypoints tell no verdict, so that one unverified site names the file") {
  const SitesServer sites;
  const auto name_of = [&](const std::string& format) {
    const std::string path = "/v1/flights/f1/sites?home_altitude_m=400&f=" + format;
    return sites.client->Get(path)->get_header_value("Content-Disposition");
  };
  CHECK(name_of("waypoints").find("f1-UNVERIFIED.waypoints") != std::string::npos);
  CHECK(name_of("kml").find("UNVERIFIED") == std::string::npos);
}

TEST_CASE("export: what makes no sense is refused by name") {
  const SitesServer sites;
  CheckProblem(sites.client->Get("/v1/sites/f1-r1?f=gpx"), 400, "InvalidQuery");
  CheckProblem(sites.client->Get("/v1/flights/f1/sites?f=html"), 400, "InvalidQuery");
  CheckProblem(sites.client->Get("/v1/sites/f1-r1?f=plan&home_altitude_m=x"), 400, "InvalidQuery");
  CheckProblem(
      sites.client->Get("/v1/sites/f1-r1?f=plan&home_altitude_m=20000"), 400, "InvalidQuery");
  CheckProblem(sites.client->Get("/v1/sites/f1-r1?format=plan"), 400, "UnknownParameter");
  CheckProblem(sites.client->Get("/v1/sites/none?f=plan"), 404, "NoSuchSite");
  CheckProblem(sites.client->Get("/v1/flights/none/sites?f=plan"), 404, "NoSuchFlight");
}

TEST_CASE("export: sites are called by the flight's name and their rank, not by their ids") {
  const SitesServer sites;
  const auto body = [&sites](const std::string& format) {
    const auto result = sites.client->Get("/v1/flights/f1/sites?home_altitude_m=400&f=" + format);
    REQUIRE(result);
    REQUIRE(result->status == 200);
    return result->body;
  };
  CHECK(body("kml").find("<name>meadows 1</name>") != std::string::npos);
  CHECK(body("kml").find("<name>meadows 2 UNVERIFIED</name>") != std::string::npos);
  CHECK(body("kml").find("<name>f1-r") == std::string::npos);
  const auto rows = SplitRows(body("cup"), ',');
  REQUIRE(rows.size() == 3);
  CHECK(rows[1][0] == "meadows 1");
  CHECK(rows[2][0] == "meadows 2 UNVERIFIED");
  CHECK(rows[1][10].find("f1-r1") != std::string::npos);
  CHECK(body("rally").find("# meadows 2 UNVERIFIED, site f1-r2") != std::string::npos);
}

TEST_CASE("export: each format with text says when the ground was photographed") {
  const SitesServer sites;
  const auto body = [&sites](const std::string& format) {
    const auto result = sites.client->Get("/v1/sites/f1-r1?home_altitude_m=300&f=" + format);
    REQUIRE(result);
    REQUIRE(result->status == 200);
    return result->body;
  };
  const std::string photographed = Rfc3339(kSeenAtUs);
  for (const char* const format : {"plan", "rally", "kml", "cup", "csv", "html"}) {
    CAPTURE(format);
    CHECK(body(format).find(photographed) != std::string::npos);
  }
  CHECK(body("html").find("40 m before touchdown; 25 %") != std::string::npos);
  const auto rows = SplitRows(body("csv"), ',');
  REQUIRE(rows.size() >= 2);
  CHECK(rows[0].size() == rows[1].size());
  const auto column = [&rows](const std::string& name) {
    const auto found = std::find(rows[0].begin(), rows[0].end(), name);
    REQUIRE(found != rows[0].end());
    return rows[1][static_cast<size_t>(found - rows[0].begin())];
  };
  CHECK(column("last_seen_at") == photographed);
  const double age_s = static_cast<double>(NowUs() - kSeenAtUs) * 1e-6;
  CHECK(std::abs(std::stod(column("age_s")) - age_s) < 60.0);
  const std::string days = std::to_string(static_cast<int64_t>(age_s / 86400.0)) + " days";
  CHECK(body("cup").find(days) != std::string::npos);
}

TEST_CASE("export: a cup's runway is as long as what was checked, rounded down") {
  const SitesServer sites;
  const auto result = sites.client->Get("/v1/sites/f1-r1?f=cup");
  REQUIRE(result);
  const auto rows = SplitRows(result->body, ',');
  CHECK(rows[0][8] == "rwlen");
  // Techpod: a disc of 10 m, and 30 m of ground roll from its middle.
  CHECK(rows[1][8] == "40m");
  CHECK_FALSE(rows[1][7].empty());
  CHECK(rows[1][9].empty());
}

TEST_CASE("export: a plan is for the firmware of the query, with the aircraft's landing speed") {
  const SitesServer sites;
  const auto plan_of = [&sites](const std::string& query) {
    return GetJson(*sites.client, "/v1/sites/f1-r1?f=plan" + query);
  };
  CHECK(plan_of("")["mission"]["firmwareType"] == 12);
  CHECK(plan_of("&firmware=px4")["mission"] == plan_of("")["mission"]);
  CHECK(plan_of("&firmware=ardupilot")["mission"]["firmwareType"] == 3);
  const nlohmann::json landing = plan_of("")["mission"]["items"][0];
  CHECK(landing["useDoChangeSpeed"] == true);
  CHECK(landing["finalApproachSpeed"] == 13.0);
  CheckProblem(
      sites.client->Get("/v1/sites/f1-r1?f=plan&firmware=betaflight"), 400, "InvalidQuery");
}

TEST_CASE("export: the plan of an unverified site warns of it before all else") {
  const SitesServer sites;
  const nlohmann::json remarks =
      GetJson(*sites.client, "/v1/flights/f1/sites?f=plan&home_altitude_m=400")["freelsd"];
  CHECK(remarks["verdict"] == "landable");
  CHECK(remarks["warnings"].dump().find("UNVERIFIED") == std::string::npos);
  CHECK(remarks["rally_points"][1]["name"] == "meadows 2 UNVERIFIED");
  const nlohmann::json unverified =
      GetJson(*sites.client, "/v1/sites/f1-r2?f=plan")["freelsd"]["warnings"];
  CHECK(unverified[0].get<std::string>().find("UNVERIFIED: ") == 0);
  CHECK(unverified.dump().find("wires") != std::string::npos);
}

TEST_CASE("layers: grass is what the flight's own settings call grass, as in hazard") {
  const SitesServer sites([](Replan& replan) {
    nlohmann::json request = nlohmann::json::parse(replan.flight.canonical_json);
    request["options"]["hazard"]["min_grass_posterior"] = 0.999;
    replan.flight = ParseStoredFlightRequest(request.dump());
  });
  const auto largest = [](const SitesServer& of) {
    const nlohmann::json answer = GetJson(*of.client, "/v1/sites/f1-r1/layers");
    for (const auto& layer : answer["layers"]) {
      if (layer["name"] == "grass") return layer["max"].get<double>();
    }
    return -1.0;
  };
  CHECK(largest(SitesServer()) == 1.0);
  CHECK(largest(sites) == 0.0);
}

TEST_CASE("export: pictures have a world file") {
  const SitesServer sites;
  const auto world = sites.client->Get("/v1/sites/f1-r1/layers/slope.pgw");
  CHECK(TypeOf(world) == "text/plain");
  CHECK(std::count(world->body.begin(), world->body.end(), '\n') == 6);
  const auto layers = GetJson(*sites.client, "/v1/sites/f1-r1/layers")["layers"];
  CHECK(layers[0]["epsg"] == 32632);
  CheckProblem(sites.client->Get("/v1/sites/f1-r1/layers/colour.pgw"), 404, "NoSuchLayer");
  CheckProblem(sites.client->Get("/v1/sites/f1-r2/layers/slope.pgw"), 404, "NoMap");
}

}  // namespace
}  // namespace freelsd
