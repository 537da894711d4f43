// The operator's base map over HTTP, and what the page may load.
#include <fstream>

#include <doctest/doctest.h>

#include "api/import/import.h"
#include "tests/server/openapi_check.h"
#include "tests/server/test_server.h"
#include "tests/storage/mbtiles_file.h"

namespace freelsd {
namespace {

constexpr char kPolicyWithoutMap[] =
    "default-src 'self'; img-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; "
    "frame-ancestors 'none'";

// A server with a page of one line, and a map in its folder.
struct MapServer {
  TemporaryFolder folder;
  std::unique_ptr<FreshServer> fresh;

  std::filesystem::path map() const { return folder.path() / "secret-name.mbtiles"; }
  void Start(const std::function<void(Config&)>& change) {
    std::filesystem::create_directories(folder.path() / "page");
    std::ofstream(folder.path() / "page/index.html") << "<html>the page</html>";
    fresh = std::make_unique<FreshServer>([&](Config& config) {
      config.page = folder.path() / "page";
      change(config);
    });
  }
  void StartWithFile() {
    Start([this](Config& config) { config.base_map_file = map(); });
  }
  std::string Policy() const {
    return fresh->client.Get("/")->get_header_value("Content-Security-Policy");
  }
};

void WriteMap(const std::filesystem::path& path) {
  MbTilesFile file(path);
  file.SetMetadata("name", "hills");
  file.SetMetadata("attribution", "&copy; <b>the survey</b>");
  file.SetMetadata("bounds", "8,47,9,48");
  file.AddTile(1, 0, 1, kPngTile);
  file.AddTile(1, 1, 1, kJpegTile);
  file.AddTile(1, 0, 0, kWebpTile);
  file.AddTile(1, 1, 0, "<html>no picture</html>");
}

TEST_CASE("base map: without one the answer is 404, and the page loads nothing from elsewhere") {
  MapServer server;
  server.Start([](Config&) {});
  CheckProblem(server.fresh->client.Get("/v1/base-map"), 404, "NoBaseMap");
  CheckProblem(server.fresh->client.Get("/v1/base-map/0/0/0"), 404, "NoBaseMap");
  CHECK(GetJson(server.fresh->client, "/v1/info")["has_base_map"] == false);
  CHECK(server.Policy() == kPolicyWithoutMap);
}

TEST_CASE("base map: with a URL the page may load pictures from that origin and nothing else") {
  MapServer server;
  server.Start([](Config& config) {
    config.base_map_url = "https://Tiles.example.org:8443/{z}/{x}/{y}.png?key=1";
    config.base_map_attribution = "&copy; <a href='x'>OpenStreetMap</a>";
    config.base_map_max_zoom = 17;
  });
  CHECK(server.Policy() ==
        "default-src 'self'; img-src 'self' data: blob: https://tiles.example.org:8443; style-src "
        "'self' 'unsafe-inline'; frame-ancestors 'none'");
  const nlohmann::json map = GetJson(server.fresh->client, "/v1/base-map");
  CHECK(GetJson(server.fresh->client, "/v1/info")["has_base_map"] == true);
  CHECK(map["tilejson"] == "3.0.0");
  CHECK(map["tiles"] == nlohmann::json{"https://Tiles.example.org:8443/{z}/{x}/{y}.png?key=1"});
  CHECK(map["attribution"] == "\u00a9 OpenStreetMap");
  CHECK(map["maxzoom"] == 17);
  CheckProblem(server.fresh->client.Get("/v1/base-map/0/0/0"), 404, "NoBaseMap");
}

TEST_CASE("base map: tiles of a file are answered with type, tag and time to keep, north first") {
  MapServer server;
  WriteMap(server.map());
  server.StartWithFile();
  httplib::Client& client = server.fresh->client;
  CHECK(server.Policy() == kPolicyWithoutMap);
  const nlohmann::json map = GetJson(client, "/v1/base-map");
  CHECK(map["tiles"] == nlohmann::json{"/v1/base-map/{z}/{x}/{y}"});
  CHECK(map["scheme"] == "xyz");
  CHECK(map["minzoom"] == 1);
  CHECK(map["maxzoom"] == 1);
  CHECK(map["attribution"] == "\u00a9 the survey");
  CHECK(map["bounds"] == nlohmann::json{8.0, 47.0, 9.0, 48.0});
  const auto tile = client.Get("/v1/base-map/1/0/0");
  REQUIRE(tile);
  CHECK(tile->status == 200);
  CHECK(tile->body == kPngTile);
  CHECK(tile->get_header_value("Content-Type") == "image/png");
  CHECK(tile->get_header_value("Cache-Control") == "private, max-age=86400");
  CHECK(tile->get_header_value("X-Content-Type-Options") == "nosniff");
  CHECK(client.Get("/v1/base-map/1/1/0")->get_header_value("Content-Type") == "image/jpeg");
  CHECK(client.Get("/v1/base-map/1/0/1")->get_header_value("Content-Type") == "image/webp");
}

TEST_CASE("base map: who has a tile is told so without it") {
  MapServer server;
  WriteMap(server.map());
  server.StartWithFile();
  httplib::Client& client = server.fresh->client;
  const std::string tag = client.Get("/v1/base-map/1/0/0")->get_header_value("ETag");
  REQUIRE_FALSE(tag.empty());
  for (const std::string& known : {tag, "W/" + tag, "\"another\", " + tag, std::string("*")}) {
    const auto same = client.Get("/v1/base-map/1/0/0", httplib::Headers{{"If-None-Match", known}});
    REQUIRE(same);
    CHECK(same->status == 304);
    CHECK(same->body.empty());
    CHECK(same->get_header_value("ETag") == tag);
  }
  const auto other = client.Get("/v1/base-map/1/1/0", httplib::Headers{{"If-None-Match", tag}});
  CHECK(other->status == 200);
  CHECK(other->get_header_value("ETag") != tag);
}

TEST_CASE("base map: tiles that are not there or unusable are refused, and the file is not named") {
  MapServer server;
  WriteMap(server.map());
  server.StartWithFile();
  httplib::Client& client = server.fresh->client;
  for (const char* const path : {"/v1/base-map/1/2/0",
                                 "/v1/base-map/0/0/0",
                                 "/v1/base-map/2/0/0",
                                 "/v1/base-map/4294967297/0/0",
                                 "/v1/base-map/1/-1/0",
                                 "/v1/base-map/1/0/0.png",
                                 "/v1/base-map/1/0/99999999999999999999",
                                 "/v1/base-map/z/x/y"}) {
    INFO(path);
    CheckProblem(client.Get(path), 404, "NoSuchTile");
  }
  const auto bad = client.Get("/v1/base-map/1/1/1");
  CheckProblem(bad, 404, "UnusableTile");
  CHECK(bad->body.find("secret-name") == std::string::npos);
  CHECK(bad->body.find("SELECT") == std::string::npos);
  CHECK(GetJson(client, "/v1/base-map").dump().find("secret-name") == std::string::npos);
  CHECK(GetJson(client, "/v1/info").dump().find("secret-name") == std::string::npos);
  CheckProblem(client.Get("/v1/base-map?f=xml"), 400, "UnknownParameter");
}

TEST_CASE(
    "base map: a file that is damaged after the start harms neither the server nor its data") {
  MapServer server;
  {
    // More than SQLite keeps in memory.
    MbTilesFile file(server.map());
    for (int i = 0; i < 8; ++i) file.AddTile(3, i, 0, kPngTile + std::string(1000000, 'x'));
  }
  server.StartWithFile();
  CHECK(server.fresh->client.Get("/v1/base-map/3/0/7")->status == 200);
  std::ofstream(server.map(), std::ios::trunc) << "no database any more";
  CheckProblem(server.fresh->client.Get("/v1/base-map/3/5/7"), 404, "UnusableTile");
  const nlohmann::json readiness = GetJson(server.fresh->client, "/readyz");
  CHECK(readiness["ready"] == true);
  CHECK(readiness["notices"].empty());
  NewFlight(server.fresh->client);
}

// The search for any tile but one never ends.
void WriteSlowMap(const std::filesystem::path& path) {
  MbTilesFile(path, "CREATE TABLE metadata (name, value);")
      .Run(
          "CREATE TABLE a (i); INSERT INTO a VALUES (1), (2), (3), (4), (5);"
          "INSERT INTO a SELECT b.i FROM a, a AS b, a AS c, a AS d;"
          "CREATE TABLE one (zoom_level, tile_column, tile_row, tile_data);"
          "INSERT INTO one VALUES (0, 0, 0, X'FFD8FF');"
          "CREATE VIEW tiles AS SELECT * FROM one UNION ALL SELECT 1, b.i, c.i + d.i, X'FFD8FF' "
          "FROM a, a AS b, a AS c, a AS d WHERE a.i + b.i + c.i + d.i > 100;"
          "INSERT INTO metadata VALUES ('minzoom', '0'), ('maxzoom', '1');");
}

TEST_CASE("base map: a search that takes too long is 503, and may be tried again") {
  MapServer server;
  WriteSlowMap(server.map());
  server.StartWithFile();
  HoldAgainstContract(server.fresh->client);
  const auto answer = server.fresh->client.Get("/v1/base-map/1/0/0");
  CheckProblem(answer, 503, "Unavailable");
  CHECK(answer->has_header("Retry-After"));
  CHECK(answer->get_header_value("Cache-Control") == "no-store");
}

TEST_CASE("base map: a server with tokens shows the map to readers only") {
  MapServer server;
  WriteMap(server.map());
  const auto tokens = server.folder.path() / "tokens.json";
  std::ofstream(tokens) << nlohmann::json{
      {{"sha256", Sha256Hex("a reader")}, {"scopes", {"read"}}}};
  std::filesystem::permissions(tokens, std::filesystem::perms::owner_read);
  server.Start([&](Config& config) {
    config.base_map_file = server.map();
    config.token_file = tokens;
  });
  CheckProblem(server.fresh->client.Get("/v1/base-map/1/0/0"), 401, "Unauthorized");
  CheckProblem(server.fresh->client.Get("/v1/base-map"), 401, "Unauthorized");
  const httplib::Headers reader{{"Authorization", "Bearer a reader"}};
  CHECK(server.fresh->client.Get("/v1/base-map/1/0/0", reader)->status == 200);
}

}  // namespace
}  // namespace freelsd
