// Damaged databases: no crash, and recall still answers.
#include <filesystem>
#include <fstream>
#include <random>

#include <doctest/doctest.h>

#include "tests/server/meadow.h"

namespace freelsd {
namespace {

constexpr char kQuery[] =
    "/v1/emergency?latitude_deg=46.9955&longitude_deg=8.0&altitude_m=600&altitude_datum=amsl"
    "&wind_east_mps=0&wind_north_mps=0&heading_deg=0";

void StoreMeadow(const std::filesystem::path& folder) {
  Storage storage(StorageAt(folder));
  storage.sites.Put(MeadowSite("amsl"), SerializeSiteMap(Meadow()));
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

}  // namespace
}  // namespace freelsd
