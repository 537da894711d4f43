// Links to autopilots over HTTP: reported, listed, commanded with a token only.
#include <filesystem>
#include <fstream>

#include <doctest/doctest.h>

#include "api/import/import.h"
#include "tests/server/meadow.h"
#include "tests/server/openapi_check.h"
#include "tests/server/site_on_map.h"
#include "tests/server/test_server.h"

namespace freelsd {
namespace {

constexpr char kJson[] = "application/json";

nlohmann::json State() {
  return {
      {"run", "r1"},
      {"is_connected", true},
      {"mode", "AUTO"},
      {"engine", {{"state", "running"}}},
      {"mission", {{"state", "unknown"}}},
      {"log", {{{"id", 1}, {"at", "2026-01-01T00:00:00Z"}, {"kind", "link"}, {"text", "armed"}}}}};
}

httplib::Result Put(httplib::Client& client, const nlohmann::json& state) {
  return client.Put("/v1/links/1", state.dump(), kJson);
}

// A meadow that is superseded, one that is not, and a rejected site; tokens of each scope.
struct LinkServer {
  TemporaryFolder folder;
  MeadowServer meadow{[](Storage& storage) {
                        SiteRow later = MeadowSite();
                        later.id = std::string("g-r1");
                        later.flight_id = std::string("g");
                        later.approach_json = R"({"type":"FeatureCollection","features":[]})";
                        PutOnMap(storage, later, Meadow(), {{"f-r1", SupersededBy("g-r1")}});
                      },
                      [this](Config& config) { config.token_file = TokenFile(); }};
  httplib::Client& client = *meadow.client;

  LinkServer() { HoldAgainstContract(client); }
  std::filesystem::path TokenFile() const {
    const nlohmann::json tokens{
        {{"sha256", Sha256Hex("link")}, {"scopes", {"read", "ingest"}}},
        {{"sha256", Sha256Hex("master")}, {"scopes", {"read", "ingest", "admin"}}},
        {{"sha256", Sha256Hex("pilot")}, {"scopes", {"read", "command"}}}};
    std::filesystem::path file = folder.path() / "tokens.json";
    std::ofstream(file) << tokens.dump();
    std::filesystem::permissions(file, std::filesystem::perms(0600));
    return file;
  }
  void As(const std::string& token) {
    client.set_default_headers({{"Authorization", "Bearer " + token}});
  }
  httplib::Result Mission(const std::string& site_id) {
    return client.Post("/v1/links/1/mission", nlohmann::json{{"site_id", site_id}}.dump(), kJson);
  }
};

TEST_CASE("links: what is reported is told, with the commands") {
  LinkServer server;
  server.As("link");
  CHECK(GetJson(server.client, "/v1/links")["links"].empty());
  CheckProblem(server.client.Get("/v1/links/1"), 404, "NoSuchLink");
  REQUIRE(Put(server.client, State())->status == 200);
  server.As("pilot");
  const auto queued = server.Mission("g-r1");
  REQUIRE(queued);
  INFO(queued->body);
  REQUIRE(queued->status == 202);
  const nlohmann::json command = nlohmann::json::parse(queued->body)["command"];
  CHECK(command["state"] == "queued");
  server.As("link");
  const nlohmann::json answer = nlohmann::json::parse(Put(server.client, State())->body);
  REQUIRE(answer["commands"].size() == 1);
  CHECK(answer["commands"][0] == command);
  nlohmann::json state = State();
  state["commands"] = {{{"id", command["id"]}, {"state", "done"}}};
  CHECK(nlohmann::json::parse(Put(server.client, state)->body)["commands"].empty());
  const nlohmann::json link = GetJson(server.client, "/v1/links/1");
  CHECK(link["mode"] == "AUTO");
  CHECK(link["is_connected"] == true);
  CHECK(link["commands"][0]["state"] == "done");
  CHECK(GetJson(server.client, "/v1/links")["links"].size() == 1);
}

TEST_CASE("links: only the scope command may command, and no scope includes it") {
  LinkServer server;
  server.As("link");
  REQUIRE(Put(server.client, State())->status == 200);
  for (const char* const token : {"link", "master"}) {
    server.As(token);
    CheckProblem(server.Mission("g-r1"), 403, "Forbidden");
    CheckProblem(server.client.Post("/v1/links/1/engine-failure"), 403, "Forbidden");
    CheckProblem(server.client.Post("/v1/links/1/release"), 403, "Forbidden");
  }
  server.As("pilot");
  CheckProblem(Put(server.client, State()), 403, "Forbidden");
  CHECK(server.client.Post("/v1/links/1/engine-failure")->status == 202);
  CHECK(server.client.Post("/v1/links/1/release", R"({"confirmed_by":"me"})", kJson)->status ==
        202);
}

TEST_CASE("links: a server without tokens, on loopback, takes reports and no commands") {
  MeadowServer meadow;
  httplib::Client& client = *meadow.client;
  HoldAgainstContract(client);
  REQUIRE(Put(client, State())->status == 200);
  CheckProblem(client.Post("/v1/links/1/engine-failure"), 401, "Unauthorized");
  client.set_default_headers({{"Authorization", "Bearer x"}});
  CheckProblem(client.Post("/v1/links/1/release"), 401, "Unauthorized");
  CheckProblem(
      client.Post("/v1/links/1/mission", R"({"site_id":"f-r1"})", kJson), 401, "Unauthorized");
}

TEST_CASE("links: no landing where nobody may land, nor for a link that nobody hears") {
  LinkServer server;
  server.As("pilot");
  CheckProblem(server.Mission("g-r1"), 404, "NoSuchLink");
  CheckProblem(server.Mission("none"), 404, "NoSuchSite");
  CheckProblem(server.Mission("f-r1"), 409, "SiteSuperseded");
  CheckProblem(server.Mission("f-r2"), 409, "SiteRejected");
  CheckProblem(server.Mission("../x"), 422, "InvalidValue");
  CheckProblem(server.client.Post("/v1/links/1/mission", "{", kJson), 400, "InvalidJson");
  CheckProblem(server.client.Post("/v1/links/1/release", R"({"x":1})", kJson), 422, "UnknownKey");
  server.As("link");
  nlohmann::json state = State();
  state["is_connected"] = false;
  REQUIRE(Put(server.client, state)->status == 200);
  server.As("pilot");
  CheckProblem(server.Mission("g-r1"), 409, "LinkSilent");
}

TEST_CASE("links: hostile reports are refused and change nothing") {
  LinkServer server;
  server.As("link");
  REQUIRE(Put(server.client, State())->status == 200);
  nlohmann::json state = State();
  state["mode"] = "RTL";
  state["wind"] = {{"east_mps", 1e9}, {"north_mps", 0}};
  CheckProblem(Put(server.client, state), 422, "InvalidValue");
  CheckProblem(server.client.Put("/v1/links/1", "[", kJson), 400, "InvalidJson");
  CheckProblem(server.client.Put("/v1/links/1", "[]", kJson), 422, "InvalidValue");
  CheckProblem(server.client.Put("/v1/links/a%20b", State().dump(), kJson), 422, "InvalidId");
  CheckProblem(
      server.client.Put("/v1/links/1", std::string(70000, ' '), kJson), 413, "BodyTooLarge");
  const std::string deep = std::string(100, '[') + std::string(100, ']');
  CheckProblem(server.client.Put("/v1/links/1", deep, kJson), 400, "InvalidJson");
  state = State();
  state["run"] = "other";
  CheckProblem(Put(server.client, state), 409, "LinkInUse");
  CheckProblem(server.client.Delete("/v1/links/1"), 405, "MethodNotAllowed");
  CHECK(GetJson(server.client, "/v1/links/1")["mode"] == "AUTO");
}

TEST_CASE("links: a new decision is an event of its flight, once") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  httplib::Client client = fresh.server.Client();
  client.set_read_timeout(10);
  std::string heard;
  bool has_begun = false;
  client.Get("/v1/events?flight=" + flight, [&](const char* bytes, size_t size) {
    heard.append(bytes, size);
    if (!has_begun) {
      nlohmann::json state = State();
      state["flight"] = {{"id", flight}, {"name", "x"}};
      Put(fresh.client, state);
      state["log"].push_back(
          {{"id", 2}, {"at", "2026-01-01T00:00:01Z"}, {"kind", "engine"}, {"text", "stopped"}});
      Put(fresh.client, state);
    }
    has_begun = true;
    return heard.find("stopped") == std::string::npos;
  });
  INFO(heard);
  const size_t first = heard.find("event: link");
  REQUIRE(first != std::string::npos);
  CHECK(heard.find("\"text\":\"armed\"") == heard.rfind("\"text\":\"armed\""));
  CHECK(heard.find("\"link\":\"1\"") != std::string::npos);
}

}  // namespace
}  // namespace freelsd
