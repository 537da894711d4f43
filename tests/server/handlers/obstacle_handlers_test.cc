// Obstacles over HTTP: stored, listed, imported, deleted, and refused.
#include <filesystem>
#include <fstream>

#include <doctest/doctest.h>

#include "api/import/import.h"
#include "server/http/stamps.h"
#include "tests/server/openapi_check.h"
#include "tests/server/test_server.h"

namespace freelsd {
namespace {

constexpr char kJson[] = "application/geo+json";

nlohmann::json Wire(double latitude_deg = 47.0) {
  const nlohmann::json line{{8.0, latitude_deg, 450.0}, {8.01, latitude_deg, 460.0}};
  return {{"type", "Feature"},
          {"geometry", {{"type", "LineString"}, {"coordinates", line}}},
          {"properties", {{"kind", "wire"}, {"name", "110 kV"}, {"altitude_datum", "amsl"}}}};
}

nlohmann::json Mast() {
  return {{"type", "Feature"},
          {"geometry", {{"type", "Point"}, {"coordinates", {9.0, 48.0}}}},
          {"properties", {{"kind", "mast"}, {"height_m", 80}}}};
}

httplib::Result Put(httplib::Client& client, const std::string& id, const nlohmann::json& feature) {
  return client.Put("/v1/obstacles/" + id, feature.dump(), kJson);
}

std::vector<std::string> Listed(httplib::Client& client, const std::string& query = "") {
  std::vector<std::string> ids;
  const nlohmann::json collection = GetJson(client, "/v1/obstacles" + query);
  for (const nlohmann::json& feature : collection["features"]) {
    ids.push_back(feature["id"]);
  }
  return ids;
}

using Ids = std::vector<std::string>;

TEST_CASE("obstacles: one is put, read, replaced and deleted") {
  FreshServer fresh;
  httplib::Client& client = fresh.client;
  HoldAgainstContract(client);
  CHECK(Put(client, "line-1", Wire())->status == 201);
  const nlohmann::json stored = GetJson(client, "/v1/obstacles/line-1");
  CHECK(stored["id"] == "line-1");
  CHECK(stored["geometry"] == Wire()["geometry"]);
  CHECK(stored["properties"]["name"] == "110 kV");
  CHECK(stored["properties"]["position_sd_m"] == 5.0);
  CHECK(stored["properties"].contains("updated_at"));
  // What is read can be written back.
  CHECK(Put(client, "line-1", stored)->status == 200);
  CHECK(Put(client, "line-1", Wire(47.5))->status == 200);
  CHECK(GetJson(client, "/v1/obstacles/line-1")["geometry"] == Wire(47.5)["geometry"]);
  CHECK(client.Delete("/v1/obstacles/line-1")->status == 204);
  CheckProblem(client.Get("/v1/obstacles/line-1"), 404, "NoSuchObstacle");
  CheckProblem(client.Delete("/v1/obstacles/line-1"), 404, "NoSuchObstacle");
}

TEST_CASE("obstacles: they survive a restart") {
  const TemporaryFolder folder;
  const Config config = TestConfig(folder.path() / "data");
  {
    TestServer server(config);
    httplib::Client client = server.Client();
    REQUIRE(Put(client, "line-1", Wire())->status == 201);
  }
  TestServer server(config);
  httplib::Client client = server.Client();
  CHECK(Listed(client) == Ids{"line-1"});
}

TEST_CASE("obstacles: the list is that of the box, over the antimeridian too") {
  FreshServer fresh;
  httplib::Client& client = fresh.client;
  HoldAgainstContract(client);
  nlohmann::json far = Mast();
  far["geometry"]["coordinates"] = {179.9, 10.0};
  REQUIRE(Put(client, "line-1", Wire())->status == 201);
  REQUIRE(Put(client, "mast-1", Mast())->status == 201);
  REQUIRE(Put(client, "far", far)->status == 201);
  CHECK(Listed(client) == Ids{"far", "line-1", "mast-1"});
  CHECK(Listed(client, "?bbox=7.5,46.5,8.005,47.5") == Ids{"line-1"});
  CHECK(Listed(client, "?bbox=7.5,46.5,7.9,47.5").empty());
  CHECK(Listed(client, "?bbox=170,0,-170,20") == Ids{"far"});
  for (const std::string box : {"1,2", "", "7,46,9,48,", "7,46,9,48,5", "7,46,,48", ",7,46,9,48"}) {
    CAPTURE(box);
    const auto refused = client.Get("/v1/obstacles?bbox=" + box);
    CheckProblem(refused, 400, "InvalidQuery");
    CHECK(nlohmann::json::parse(refused->body)["errors"][0]["pointer"] == "bbox");
  }
}

TEST_CASE("obstacles: an edit is later than what a clock that is ahead has stamped") {
  FreshServer fresh;
  httplib::Client& client = fresh.client;
  REQUIRE(Put(client, "line-1", Wire())->status == 201);
  nlohmann::json page = nlohmann::json::parse(client.Get("/v1/changes")->body);
  nlohmann::json told = page["changes"][0];
  const int64_t ahead_us = told["obstacle"]["updated_at_us"].get<int64_t>() + 3'600'000'000;
  told["obstacle"]["updated_at_us"] = ahead_us;
  told["origin"] = "elsewhere";
  const std::string body = nlohmann::json{{"changes", {told}}}.dump();
  REQUIRE(client.Post("/v1/changes", body, kJson)->status == 200);
  REQUIRE(Put(client, "line-1", Wire())->status == 200);
  page = nlohmann::json::parse(client.Get("/v1/changes")->body);
  CHECK(page["changes"][0]["obstacle"]["updated_at_us"] == ahead_us + 1);
}

TEST_CASE("obstacles: a collection is stored as a whole or not at all") {
  FreshServer fresh;
  httplib::Client& client = fresh.client;
  HoldAgainstContract(client);
  nlohmann::json named = Wire();
  named["id"] = "line-1";
  nlohmann::json collection{{"type", "FeatureCollection"}, {"features", {named, Mast()}}};
  for (int i = 0; i < 2; ++i) {
    const auto result = client.Post("/v1/obstacles", collection.dump(), kJson);
    REQUIRE(result->status == 200);
    CHECK(nlohmann::json::parse(result->body)["ids"].size() == 2);
    // The second time the same two are replaced.
    CHECK(Listed(client).size() == 2);
  }
  collection["features"] = {named, named};
  CheckProblem(client.Post("/v1/obstacles", collection.dump(), kJson), 422, "DuplicateId");
  nlohmann::json bad = Mast();
  bad["properties"].erase("height_m");
  nlohmann::json other = Wire();
  other["id"] = "line-2";
  collection["features"] = {other, bad};
  const auto refused = client.Post("/v1/obstacles", collection.dump(), kJson);
  CheckProblem(refused, 422, "InvalidValue");
  CHECK(nlohmann::json::parse(refused->body)["errors"][0]["pointer"] ==
        "/features/1/geometry/coordinates");
  CHECK(Listed(client).size() == 2);
}

TEST_CASE("obstacles: airspaces come as OpenAir") {
  FreshServer fresh;
  httplib::Client& client = fresh.client;
  HoldAgainstContract(client);
  const auto result =
      client.Post("/v1/obstacles",
                  "* test\nAC D\nAN CTR\nAL GND\nAH 2000 FT AGL\nV X=47:00 N 8:00 E\nDC 3\n",
                  "text/plain");
  REQUIRE(result->status == 200);
  const nlohmann::json answer = nlohmann::json::parse(result->body);
  CHECK(answer["ids"] == nlohmann::json{"airspace-CTR"});
  CHECK(answer["warnings"].empty());
  const nlohmann::json properties = GetJson(client, "/v1/obstacles/airspace-CTR")["properties"];
  CHECK(properties["kind"] == "no_fly");
  CHECK(properties["ceiling_m"].is_null());
  CHECK(properties["ceiling_above_ground_m"] == doctest::Approx(609.6));
  CheckProblem(client.Post("/v1/obstacles", "AC D\nAL x\n", "text/plain"), 422, "InvalidAirspace");
}

TEST_CASE("obstacles: a body that is neither GeoJSON nor OpenAir is refused for what it is") {
  FreshServer fresh;
  httplib::Client& client = fresh.client;
  HoldAgainstContract(client);
  const auto post = [&client](const std::string& body, const std::string& type) {
    return client.Post("/v1/obstacles", body, type);
  };
  for (const std::string body : {"", "junk", "<xml/>", "[8, 47]"}) {
    CAPTURE(body);
    for (const std::string type : {"text/plain; charset=utf-8", "application/octet-stream"}) {
      const auto refused = post(body, type);
      CheckProblem(refused, 422, "InvalidAirspace");
      CHECK(nlohmann::json::parse(refused->body)["errors"][0]["pointer"] == "line 1");
    }
    CheckProblem(post(body, "application/xml"), 415, "UnsupportedMediaType");
    CheckProblem(post(body, "text/html"), 415, "UnsupportedMediaType");
  }
  CheckProblem(post("junk", kJson), 400, "InvalidJson");
  CheckProblem(post("", "application/json"), 400, "InvalidJson");
  CheckProblem(post("{", "text/plain"), 400, "InvalidJson");
  CheckProblem(post("[8, 47]", kJson), 422, "InvalidValue");
  CHECK(Listed(client).empty());
  // The first bytes tell what it is, whatever the type.
  const nlohmann::json collection{{"type", "FeatureCollection"}, {"features", {Wire()}}};
  CHECK(post("\n" + collection.dump(), "application/x-www-form-urlencoded")->status == 200);
  CHECK(post("\xEF\xBB\xBF" + collection.dump(), "text/plain")->status == 200);
}

TEST_CASE("obstacles: bad requests are refused and change nothing") {
  FreshServer fresh;
  httplib::Client& client = fresh.client;
  HoldAgainstContract(client);
  CheckProblem(client.Put("/v1/obstacles/a", "{", kJson), 400, "InvalidJson");
  CheckProblem(Put(client, "a%20b", Wire()), 422, "InvalidId");
  CheckProblem(Put(client, "a%00b", Wire()), 422, "InvalidId");
  nlohmann::json one_place = Wire();
  one_place["geometry"]["coordinates"][1] = one_place["geometry"]["coordinates"][0];
  CheckProblem(Put(client, "a", one_place), 422, "InvalidValue");
  nlohmann::json wire = Wire();
  wire["id"] = "other";
  CheckProblem(Put(client, "a", wire), 422, "InvalidValue");
  nlohmann::json people = Mast();
  people["properties"] = {{"kind", "people"}, {"expires_at", "2020-01-01T00:00:00Z"}};
  const auto past = Put(client, "a", people);
  CheckProblem(past, 422, "InvalidValue");
  CHECK(nlohmann::json::parse(past->body)["errors"][0]["pointer"] == "/properties/expires_at");
  const std::string large(kLimits.obstacles.max_bytes + 1, ' ');
  CHECK(client.Put("/v1/obstacles/a", large, kJson)->status == 413);
  CheckProblem(client.Post("/v1/obstacles/a"), 405, "MethodNotAllowed");
  CHECK(Listed(client).empty());
}

TEST_CASE("obstacles: people who expire are not listed any more") {
  FreshServer fresh;
  httplib::Client& client = fresh.client;
  nlohmann::json people = Mast();
  people["properties"] = {{"kind", "people"}, {"expires_at", Rfc3339(NowUs() + 2000000)}};
  REQUIRE(Put(client, "fair", people)->status == 201);
  CHECK(Listed(client) == Ids{"fair"});
  std::this_thread::sleep_for(std::chrono::milliseconds(2500));
  CHECK(Listed(client).empty());
  CheckProblem(client.Get("/v1/obstacles/fair"), 404, "NoSuchObstacle");
  // Its id is free again.
  CHECK(Put(client, "fair", Mast())->status == 201);
}

TEST_CASE("obstacles: only an administrator may change them, every reader may read") {
  const TemporaryFolder folder;
  const nlohmann::json tokens{
      {{"sha256", Sha256Hex("sender")}, {"scopes", {"read", "ingest"}}},
      {{"sha256", Sha256Hex("master")}, {"scopes", {"read", "ingest", "admin"}}}};
  const std::filesystem::path file = folder.path() / "tokens.json";
  std::ofstream(file) << tokens.dump();
  std::filesystem::permissions(file, std::filesystem::perms(0600));
  Config config = TestConfig(folder.path() / "data");
  config.token_file = file;
  TestServer server(config);
  httplib::Client client = server.Client();
  const auto as = [&client](const std::string& token) {
    client.set_default_headers({{"Authorization", "Bearer " + token}});
  };
  as("sender");
  CheckProblem(Put(client, "a", Wire()), 403, "Forbidden");
  CheckProblem(client.Post("/v1/obstacles", "{}", kJson), 403, "Forbidden");
  CheckProblem(client.Delete("/v1/obstacles/a"), 403, "Forbidden");
  as("master");
  CHECK(Put(client, "a", Wire())->status == 201);
  as("sender");
  CHECK(client.Get("/v1/obstacles/a")->status == 200);
  CHECK(client.Get("/v1/obstacles")->status == 200);
}

}  // namespace
}  // namespace freelsd
