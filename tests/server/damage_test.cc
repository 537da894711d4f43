// Damaged databases: no crash, and recall still answers.
#include <filesystem>
#include <fstream>
#include <random>

#include <doctest/doctest.h>

#include "tests/server/meadow.h"
#include "tests/server/site_on_map.h"

namespace freelsd {
namespace {

constexpr char kQuery[] =
    "/v1/emergency?latitude_deg=46.9955&longitude_deg=8.0&altitude_m=600&altitude_datum=amsl"
    "&wind_east_mps=0&wind_north_mps=0&heading_deg=0";

void StoreMeadow(const std::filesystem::path& folder) {
  Storage storage(StorageAt(folder));
  PutOnMap(storage, MeadowSite("amsl"), Meadow());
}

// Bits turned, pages lost, or the end cut off.
void Spoil(const std::filesystem::path& file, unsigned seed) {
  std::mt19937 random(seed);
  const uint64_t size = std::filesystem::file_size(file);
  const auto somewhere = [&] { return static_cast<std::streamoff>(random() % size); };
  if (seed % 3 == 0) {
    std::filesystem::resize_file(file, random() % size);
    return;
  }
  std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
  if (seed % 3 == 1) {
    stream.seekp(somewhere());
    stream << std::string(std::min<uint64_t>(random() % 30000, size), '\0');
    return;
  }
  for (int i = 0; i < 200; ++i) {
    stream.seekp(somewhere());
    stream.put(static_cast<char>(random()));
  }
}

TEST_CASE("damage: of 24 spoilt databases each still gives the emergency answer") {
  constexpr unsigned kNumDatabases = 24;
  const TemporaryFolder master;
  StoreMeadow(master.path() / "data");
  for (unsigned seed = 0; seed < kNumDatabases; ++seed) {
    INFO("seed " << seed);
    const TemporaryFolder folder;
    std::filesystem::copy(
        master.path() / "data", folder.path() / "data", std::filesystem::copy_options::recursive);
    Spoil(folder.path() / "data/freelsd.db", seed);
    const TestServer server(TestConfig(folder.path() / "data"));
    httplib::Client client = server.Client();
    const nlohmann::json answer = GetJson(client, kQuery);
    CHECK(answer["sites"].size() == 1);
    CHECK(client.Get("/v1/flights"));
    CHECK(client.Get("/readyz"));
  }
}

TEST_CASE("damage: readiness tells of it, and of what was set aside at the start") {
  const TemporaryFolder folder;
  const std::filesystem::path data = folder.path() / "data";
  StoreMeadow(data);
  std::filesystem::resize_file(data / "freelsd.db", 5000);
  const TestServer server(TestConfig(data));
  httplib::Client client = server.Client();
  const auto ready = client.Get("/readyz");
  REQUIRE(ready);
  CHECK(ready->body.find("damaged") != std::string::npos);
  CHECK(GetJson(client, kQuery)["sites"].size() == 1);
  CHECK(client.Get("/metrics")->body.find("freelsd_notices 1") != std::string::npos);
}

// The answers of recall, whose warnings a pilot reads.
std::vector<nlohmann::json> Recalls(httplib::Client& client) {
  const std::string place = std::string(kQuery).substr(std::string("/v1/emergency").size());
  const auto route =
      client.Post("/v1/routes/check",
                  R"({"route":[{"latitude_deg":47,"longitude_deg":8,"altitude_m":900},)"
                  R"({"latitude_deg":47.001,"longitude_deg":8,"altitude_m":900}],)"
                  R"("altitude_datum":"amsl","airspeed_mps":15,)"
                  R"("wind":{"east_mps":0,"north_mps":0}})",
                  "application/json");
  REQUIRE(route->status == 200);
  return {GetJson(client, kQuery),
          GetJson(client, "/v1/reach" + place),
          nlohmann::json::parse(route->body)};
}

bool Warns(const nlohmann::json& answer, const std::string& of) {
  return answer["warnings"].dump().find(of) != std::string::npos;
}

TEST_CASE("damage: of both databases: every recall says so, until it is acknowledged") {
  const TemporaryFolder folder;
  const std::filesystem::path data = folder.path() / "data";
  StoreMeadow(data);
  for (const char* const name : {"freelsd.db", "recall.db"}) {
    std::ofstream(data / name) << std::string(20000, 'x');
  }
  const std::string said = "nothing could be restored";
  std::string id;
  for (int start = 0; start < 2; ++start) {
    CAPTURE(start);
    const TestServer server(TestConfig(data));
    httplib::Client client = server.Client();
    const nlohmann::json notices = GetJson(client, "/v1/notices")["notices"];
    REQUIRE(notices.size() == 1);
    CHECK(notices[0]["text"].get<std::string>().find(said) != std::string::npos);
    CHECK(notices[0]["acknowledged_at"].is_null());
    id = notices[0]["id"];
    CHECK(GetJson(client, "/readyz").dump().find(said) != std::string::npos);
    for (const nlohmann::json& answer : Recalls(client)) CHECK(Warns(answer, said));
  }
  const TestServer server(TestConfig(data));
  httplib::Client client = server.Client();
  CheckProblem(client.Post("/v1/notices/7/acknowledge"), 404, "NoSuchNotice");
  const auto acknowledged = client.Post("/v1/notices/" + id + "/acknowledge");
  REQUIRE(acknowledged->status == 200);
  CHECK(nlohmann::json::parse(acknowledged->body)["acknowledged_at"].is_string());
  CHECK(GetJson(client, "/v1/notices")["notices"].size() == 1);
  for (const nlohmann::json& answer : Recalls(client)) CHECK_FALSE(Warns(answer, said));
}

TEST_CASE("notices: who may only read or send may not acknowledge") {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "tokens.json";
  std::ofstream(file) << nlohmann::json{
      {{"sha256", Sha256Hex("sender")}, {"scopes", {"read", "ingest"}}}};
  std::filesystem::permissions(file, std::filesystem::perms(0600));
  Config config = TestConfig(folder.path() / "data");
  config.token_file = file;
  const TestServer server(config);
  httplib::Client client = server.Client();
  client.set_default_headers({{"Authorization", "Bearer sender"}});
  CHECK(client.Get("/v1/notices")->status == 200);
  CheckProblem(client.Post("/v1/notices/1/acknowledge"), 403, "Forbidden");
}

}  // namespace
}  // namespace freelsd
