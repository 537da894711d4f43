// Every route of the table in server/routes.cc, with the token of an organisation that has nothing.
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "tests/server/organisations/two_organisations.h"

namespace freelsd {
namespace {

constexpr char kFlight[] = "/v1/flights/north-flight";
constexpr char kPlace[] = "latitude_deg=47.01&longitude_deg=8&altitude_m=900&altitude_datum=amsl";
constexpr char kLink[] =
    R"({"run":"r1","is_connected":true,"mode":"north-mode","engine":{"state":"running"},)"
    R"("mission":{"state":"unknown"}})";
constexpr char kFeature[] = R"({"type":"Feature","geometry":{"type":"Point","coordinates":[9,48]},)"
                            R"("properties":{"kind":"mast","height_m":80}})";

// A request for a route, and what the other organisation gets. `owner_gets`: what whose it is gets
// before; 0: not asked, because the request would change something.
struct Walk {
  std::string route;
  std::string path;
  int other_gets = 404;
  int owner_gets = 200;
  std::string body = std::string();
};

std::vector<Walk> WalksOfFlights() {
  const std::string flight = kFlight;
  return {{"GET /v1/flights", "/v1/flights", 200},
          {"GET /v1/flights/{flight}", flight},
          {"GET /v1/flights/{flight}/track", flight + "/track"},
          {"GET /v1/flights/{flight}/frames", flight + "/frames"},
          {"GET /v1/flights/{flight}/frames/{frame}/patch.png",
           flight + "/frames/north-frame/patch.png?x_px=50&y_px=50&side_px=32"},
          {"GET /v1/flights/{flight}/alternates", flight + "/alternates"},
          {"GET /v1/flights/{flight}/regions", flight + "/regions"},
          {"GET /v1/flights/{flight}/regions/{region}/history", flight + "/regions/1/history"},
          {"GET /v1/flights/{flight}/sites", flight + "/sites"},
          {"GET /v1/flights/{flight}/map", flight + "/map"},
          {"GET /v1/flights/{flight}/map/{layer}/{z}/{x}/{y}.png",
           flight + "/map/slope/10/534/358.png"},
          {"GET /v1/flights/{flight}/map/{layer}/{z}/{x}/{y}.jpg",
           flight + "/map/photo/10/534/358.jpg"},
          {"GET /v1/flights/{flight}/map/{layer}/legend.png", flight + "/map/slope/legend.png"},
          {"GET /v1/flights/{flight}/map/{layer}.tif", flight + "/map/slope.tif"},
          {"GET /v1/flights/{flight}/map/{layer}.kmz", flight + "/map/hazard.kmz"},
          {"GET /v1/flights/{flight}/why", flight + "/why?latitude_deg=47&longitude_deg=8"},
          {"GET /v1/flights/{flight}/landing", flight + "/landing?latitude_deg=47&longitude_deg=8"},
          {"GET /v1/flights/{flight}/next-look", flight + "/next-look", 404, 0},
          {"PUT /v1/flights/{flight}/frames/{frame}", flight + "/frames/north-frame", 404, 0, "x"},
          {"POST /v1/flights/{flight}/frames", flight + "/frames", 404, 0, "x"},
          {"POST /v1/flights/{flight}/batch", flight + "/batch", 404, 0, "x"},
          {"POST /v1/flights/{flight}/finish", flight + "/finish", 404, 0},
          {"POST /v1/flights/{flight}/replay", flight + "/replay", 404, 0},
          {"POST /v1/flights/{flight}/telemetry", flight + "/telemetry", 404, 0, "{}"},
          {"POST /v1/flights/{flight}/stream", flight + "/stream", 404, 0, "x"},
          {"PATCH /v1/flights/{flight}", "/v1/flights/north-flight", 404, 0, R"({"name":"a"})"},
          {"DELETE /v1/flights/{flight}", flight + "?forget_sites=true", 404, 0},
          {"POST /v1/flights", "/v1/flights", 201, 0, R"({"name":"of the south"})"}};
}

std::vector<Walk> WalksOfSites() {
  const std::string site = "/v1/sites/north-site";
  const std::string place = kPlace;
  return {{"GET /v1/sites", "/v1/sites", 200},
          {"GET /v1/sites/{site}", site},
          {"GET /v1/sites/{site}/approach", site + "/approach?wind_east_mps=0&wind_north_mps=0"},
          {"GET /v1/sites/{site}/why", site + "/why?latitude_deg=47&longitude_deg=8"},
          {"GET /v1/sites/{site}/wind-rose", site + "/wind-rose?directions=4&speeds_mps=0"},
          {"GET /v1/sites/{site}/layers", site + "/layers"},
          {"GET /v1/sites/{site}/layers/{layer}.png", site + "/layers/slope.png"},
          {"GET /v1/sites/{site}/layers/{layer}.pgw", site + "/layers/slope.pgw"},
          {"GET /v1/sites/{site}/layers/{layer}.tif", site + "/layers/slope.tif"},
          {"GET /v1/sites/{site}/layers/{layer}/legend.png", site + "/layers/slope/legend.png"},
          {"DELETE /v1/sites/{site}", site, 404, 0},
          {"GET /v1/emergency", "/v1/emergency?" + place, 200},
          {"POST /v1/emergency", "/v1/emergency?" + place, 200},
          {"GET /v1/emergency/export", "/v1/emergency/export", 200},
          {"GET /v1/reach", "/v1/reach?" + place, 200},
          {"POST /v1/reach", "/v1/reach?" + place, 200},
          {"POST /v1/routes/check",
           "/v1/routes/check",
           200,
           200,
           R"({"route":[{"latitude_deg":47,"longitude_deg":8,"altitude_m":900},)"
           R"({"latitude_deg":47.001,"longitude_deg":8,"altitude_m":900}],"altitude_datum":"amsl",)"
           R"("airspeed_mps":15,"wind":{"east_mps":0,"north_mps":0}})"}};
}

std::vector<Walk> OtherWalks() {
  return {
      {"GET /v1/changes", "/v1/changes", 200},
      {"GET /v1/events", "/v1/events?flight=north-flight", 404, 0},
      {"GET /v1/jobs", "/v1/jobs", 200},
      {"GET /v1/jobs/{job}", "/v1/jobs/north-job"},
      {"DELETE /v1/jobs/{job}", "/v1/jobs/north-job", 404, 0},
      {"GET /v1/obstacles", "/v1/obstacles", 200},
      {"GET /v1/obstacles/{obstacle}", "/v1/obstacles/north-mast"},
      {"DELETE /v1/obstacles/{obstacle}", "/v1/obstacles/north-mast", 404, 0},
      // They are its own, whatever id it chooses.
      {"PUT /v1/obstacles/{obstacle}", "/v1/obstacles/north-mast", 201, 0, kFeature},
      {"POST /v1/obstacles",
       "/v1/obstacles",
       200,
       0,
       std::string(R"({"type":"FeatureCollection","features":[)") + kFeature + "]}"},
      {"GET /v1/notices", "/v1/notices", 200},
      {"POST /v1/notices/{notice}/acknowledge", "/v1/notices/1/acknowledge", 404, 404},
      {"GET /v1/links", "/v1/links", 200},
      {"GET /v1/links/{link}", "/v1/links/north-link"},
      {"POST /v1/links/{link}/mission",
       "/v1/links/north-link/mission",
       404,
       0,
       R"({"site_id":"north-site"})"},
      {"POST /v1/links/{link}/engine-failure", "/v1/links/north-link/engine-failure", 404, 0, "{}"},
      {"POST /v1/links/{link}/release", "/v1/links/north-link/release", 404, 0, "{}"},
      {"PUT /v1/links/{link}", "/v1/links/south-link", 200, 0, kLink},
      {"POST /v1/changes", "/v1/changes", 200, 0, R"({"changes":[]})"},
      {"GET /v1/maps/{flight}/{number}", "/v1/maps/north-flight/1"},
      {"PUT /v1/maps/{flight}/{number}", "/v1/maps/north-flight/1", 422, 0, "no map"},
      {"GET /v1/base-map", "/v1/base-map", 404, 404},
      {"GET /v1/base-map/{z}/{x}/{y}", "/v1/base-map/1/0/0", 404, 404},
      {"GET /healthz", "/healthz", 200},
      {"GET /readyz", "/readyz", 200},
      {"GET /metrics", "/metrics", 200},
      {"GET /v1/info", "/v1/info", 200},
      {"GET /openapi.json", "/openapi.json", 200}};
}

std::vector<Walk> AllWalks() {
  std::vector<Walk> walks = WalksOfFlights();
  for (const auto& more : {WalksOfSites(), OtherWalks()}) {
    walks.insert(walks.end(), more.begin(), more.end());
  }
  return walks;
}

std::set<std::string> RoutesInSource() {
  std::ifstream file(std::string(FREELSD_SOURCE_DIR) + "/server/routes.cc");
  const std::string text(std::istreambuf_iterator<char>(file), {});
  const std::regex route("\\{\"([A-Z]+)\",\\s*\"(/[^\"]*)\"");
  std::set<std::string> routes;
  for (std::sregex_iterator it(text.begin(), text.end(), route); it != std::sregex_iterator();
       ++it) {
    routes.insert((*it)[1].str() + " " + (*it)[2].str());
  }
  return routes;
}

httplib::Result Ask(httplib::Client& client, const Walk& walk) {
  httplib::Request request;
  request.method = walk.route.substr(0, walk.route.find(' '));
  request.path = walk.path;
  request.body = walk.body;
  if (!walk.body.empty()) request.set_header("Content-Type", "application/json");
  return client.send(request);
}

// What the owner sees of itself, but for what depends on the time.
std::map<std::string, std::string> SeenBy(httplib::Client& owner) {
  std::map<std::string, std::string> seen;
  for (const char* const path :
       {"/v1/jobs", "/v1/obstacles", "/v1/flights", "/v1/flights/north-flight/frames"}) {
    const auto answer = owner.Get(path);
    REQUIRE(answer);
    seen[path] = answer->body;
  }
  return seen;
}

TEST_SUITE("postgresql" * doctest::skip()) {
  TEST_CASE("organisations: no route answers what is another organisation's") {
    const TwoOrganisations two;
    httplib::Client owner = two.As("north");
    httplib::Client other = two.As("south");
    REQUIRE(owner.Put("/v1/links/north-link", kLink, "application/json")->status == 200);
    std::set<std::string> walked;
    const std::map<std::string, std::string> before = SeenBy(owner);
    for (const Walk& walk : AllWalks()) {
      CAPTURE(walk.route);
      walked.insert(walk.route);
      if (walk.owner_gets != 0) {
        const auto own = Ask(owner, walk);
        REQUIRE(own);
        CHECK_MESSAGE(own->status == walk.owner_gets, own->body);
      }
      const auto answer = Ask(other, walk);
      REQUIRE(answer);
      CHECK_MESSAGE(answer->status == walk.other_gets, answer->body);
      // What it has put itself may say what it has put.
      if (walk.path.find("south") != std::string::npos || walk.route.starts_with("PUT")) continue;
      if (walk.route == "GET /v1/links" || walk.route == "GET /openapi.json") continue;
      CHECK_MESSAGE(answer->body.find(kSecret) == std::string::npos, answer->body);
    }
    CHECK(walked == RoutesInSource());
    CHECK(SeenBy(owner) == before);
    CHECK(owner.Get("/v1/sites/north-site")->status == 200);
  }

  TEST_CASE("organisations: the owner is told of its sites in an emergency, the other is not") {
    const TwoOrganisations two;
    httplib::Client owner = two.As("north");
    httplib::Client other = two.As("south");
    const std::string path = std::string("/v1/emergency?") + kPlace;
    CHECK(GetJson(owner, path).at("sites").size() > 0);
    CHECK(GetJson(other, path).at("sites").empty());
    two.north->ShareSites(true);
    CHECK(GetJson(other, path).at("sites").size() > 0);
    two.north->ShareSites(false);
    CHECK(GetJson(other, path).at("sites").empty());
  }

  TEST_CASE("organisations: events reach listeners of their organisation only") {
    const TwoOrganisations two;
    httplib::Client owner = two.As("north");
    httplib::Client other = two.As("south");
    RawConnection heard(two.server->port());
    heard.Send(
        "GET /v1/events HTTP/1.1\r\nHost: 127.0.0.1\r\nAuthorization: Bearer token of "
        "south\r\n\r\n");
    heard.ReceiveUntil("retry: ");
    REQUIRE(owner.Put("/v1/links/north-link", kLink, "application/json")->status == 200);
    two.north->claims.Tell({0, "frame", "north-flight", R"({"id":"north-frame"})", "north"});
    const std::string flight = NewFlight(other);
    REQUIRE(PutFrame(other, flight, "last", NoiseImage(2), SomeMeta())->status == 201);
    const std::string text = heard.ReceiveUntil("\"last\"");
    CHECK_FALSE(text.empty());
    CHECK(text.find(kSecret) == std::string::npos);
  }
}

}  // namespace
}  // namespace freelsd
