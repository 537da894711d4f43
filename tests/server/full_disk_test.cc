// A disk without space: writes are 507, reads go on, and space that returns is used.
#include <chrono>
#include <fstream>
#include <set>
#include <thread>

#include <doctest/doctest.h>

#include "tests/server/child.h"
#include "tests/server/sample_flight.h"
#include "tests/storage/small_disk.h"

namespace freelsd {
namespace {

// PNGs of noise do not shrink: about 230 kB each.
std::string LargeImage(int seed) { return NoiseImage(seed, 320, 240, ".png"); }

TEST_CASE(
    "full disk: an upload is 507 and stores nothing, reads go on, space that returns is used") {
  constexpr int kMaxNumUploads = 200;
  const TemporaryFolder folder;
  const SmallDisk disk(folder.path() / "data", "6m");
  if (!IsMounted(disk)) return;
  const TestServer server(TestConfig(folder.path() / "data"));
  httplib::Client client = server.Client();
  const std::string flight = NewFlight(client), unwanted = NewFlight(client);
  int num_stored = 0;
  httplib::Result result(nullptr, httplib::Error::Unknown);
  for (; num_stored < kMaxNumUploads; ++num_stored) {
    result = PutFrame(
        client, flight, std::to_string(num_stored), LargeImage(num_stored), SomeMeta(num_stored));
    REQUIRE(result);
    if (result->status != 201) break;
  }
  CheckProblem(result, 507, "StorageFull");
  REQUIRE(num_stored > 0);
  CHECK(FrameList(client, flight).size() == static_cast<size_t>(num_stored));
  CHECK(client.Get("/healthz")->status == 200);
  CHECK(client.Get("/readyz")->status == 503);
  CHECK(GetJson(client, "/v1/flights")["flights"].size() == 2);
  CHECK(client.Get("/v1/sites")->status == 200);
  // Small images do not find a place that large ones left.
  int num_small = 0;
  for (; num_small < kMaxNumUploads; ++num_small) {
    const std::string small = NoiseImage(1000 + num_small);
    result = PutFrame(client, flight, "s" + std::to_string(num_small), small, SomeMeta());
    REQUIRE(result);
    if (result->status != 201) break;
  }
  CheckProblem(result, 507, "StorageFull");
  const auto space = std::filesystem::space(folder.path() / "data");
  // Images leave the database room enough to make room.
  CHECK(space.available > space.capacity / 32);
  CHECK(client.Delete("/v1/flights/" + unwanted)->status == 204);
  // More room on the same disk; the server is not started again.
  REQUIRE(disk.Resize("64m"));
  const std::string id = std::to_string(num_stored);
  CHECK(PutFrame(client, flight, id, LargeImage(num_stored), SomeMeta(num_stored))->status == 201);
  CHECK(FrameList(client, flight).size() == static_cast<size_t>(num_stored + num_small) + 1);
}

TEST_CASE("full disk: an obstacle whose change is refused is as before, also after damage") {
  const TemporaryFolder folder;
  const std::filesystem::path data = folder.path() / "disk/data";
  const SmallDisk disk(folder.path() / "disk", "12m");
  if (!IsMounted(disk)) return;
  const auto mast = [](const std::string& id) {
    return R"({"type":"Feature","id":")" + id +
           R"(","geometry":{"type":"Point","coordinates":[8,47]},)"
           R"("properties":{"kind":"mast","height_m":30}})";
  };
  std::set<std::string> accepted;
  int num_refused = 0;
  {
    const TestServer server(TestConfig(data));
    httplib::Client client = server.Client();
    for (int i = 0; i < 30; ++i) {
      const std::string id = "mast-" + std::to_string(i);
      const std::string path = "/v1/obstacles/" + id;
      REQUIRE(client.Put(path, mast(id), "application/json")->status == 201);
      disk.Fill(static_cast<uint64_t>(i) * 4096);
      const auto deleted = client.Delete(path);
      const std::string other = "other-" + std::to_string(i);
      const auto put = client.Put("/v1/obstacles/" + other, mast(other), "application/json");
      for (const httplib::Result* result : {&deleted, &put}) {
        if ((*result)->status < 300) continue;
        CheckProblem(*result, 507, "StorageFull");
        ++num_refused;
      }
      if (deleted->status != 204) accepted.insert(id);
      if (put->status == 201) accepted.insert(other);
      disk.MakeRoom();
    }
  }
  CHECK(num_refused > 0);
  std::ofstream(data / "freelsd.db") << std::string(20000, 'x');
  const TestServer server(TestConfig(data));
  httplib::Client client = server.Client();
  std::set<std::string> stored;
  const nlohmann::json listed = GetJson(client, "/v1/obstacles");
  for (const nlohmann::json& each : listed["features"]) stored.insert(each["id"]);
  CHECK(stored == accepted);
}

TEST_CASE("full disk: a finish stops with the reason, and goes on when there is room") {
  const TemporaryFolder folder;
  const SmallDisk disk(folder.path() / "disk", "60m");
  if (!IsMounted(disk)) return;
  Config config = TestConfig(folder.path() / "disk/data");
  config.model = RealModel();
  const TestServer server(config);
  httplib::Client client = server.Client();
  const std::string flight = PostSampleFlight(client, 0, kNumSampleFrames / 2);
  const nlohmann::json jobs = GetJson(client, "/v1/jobs")["jobs"];
  AwaitJob(client, jobs[0]["id"]);
  const std::string job = Finish(client, flight);
  disk.Fill(0);
  nlohmann::json view;
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(2);
  do {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    view = GetJson(client, "/v1/jobs/" + job);
  } while (!view["detail"].contains("message") && std::chrono::steady_clock::now() < deadline);
  INFO(view.dump());
  CHECK(view["state"] == "queued");
  CHECK(view["detail"]["message"].get<std::string>().find("the disk is full") == 0);
  CHECK(view["summary"] == view["detail"]["message"]);
  CHECK(view["time_left_s"].is_null());
  // It does not begin again by itself.
  std::this_thread::sleep_for(std::chrono::seconds(3));
  CHECK(GetJson(client, "/v1/jobs/" + job)["detail"].contains("message"));
  CHECK(GetJson(client, "/v1/flights/" + flight)["num_sites"] == 0);
  disk.MakeRoom();
  const nlohmann::json ended = AwaitJob(client, job);
  CHECK(ended["state"] == "done");
  CHECK_FALSE(ended["detail"].contains("message"));
}

TEST_CASE("full disk: who waits for frames is told once that they are held, tried or not") {
  const TemporaryFolder folder;
  const SmallDisk disk(folder.path() / "disk", "60m");
  if (!IsMounted(disk)) return;
  Config config = TestConfig(folder.path() / "disk/data");
  config.model = RealModel();
  const TestServer server(config);
  httplib::Client client = server.Client();
  const std::string flight = PostSampleFlight(client, 0, kNumSampleFrames);
  disk.Fill(0);
  const std::string job = GetJson(client, "/v1/jobs")["jobs"][0]["id"];
  // Longer than three times between tries.
  constexpr std::chrono::seconds kListening(8);
  httplib::Client listener = server.Client();
  listener.set_read_timeout(kListening);
  std::string heard;
  const auto begin = std::chrono::steady_clock::now();
  listener.Get("/v1/events?flight=" + flight, [&](const char* bytes, size_t size) {
    heard.append(bytes, size);
    return std::chrono::steady_clock::now() - begin < kListening;
  });
  const size_t held_at = heard.find("\"message\":\"the disk is full");
  INFO(heard);
  REQUIRE(held_at != std::string::npos);
  CHECK(heard.find("event: job", held_at) == std::string::npos);
  disk.MakeRoom();
  const nlohmann::json ended = AwaitJob(client, job);
  CHECK(ended["state"] == "done");
  CHECK_FALSE(ended["detail"].contains("message"));
}

TEST_CASE("full disk: a file that cannot grow is 507 too, without any privilege to test it") {
  const TemporaryFolder folder;
  ChildOptions options{folder.path()};
  // Room for the database, not for the larger image.
  options.max_file_bytes = uint64_t{1} << 20;
  Child child(options);
  httplib::Client client = ClientOf(child.AwaitPort());
  const std::string flight = NewFlight(client, 1600, 1200);
  const std::string large = NoiseImage(1, 1600, 1200);
  REQUIRE(large.size() > options.max_file_bytes);
  CheckProblem(PutFrame(client, flight, "one", large, SomeMeta()), 507, "StorageFull");
  CHECK(FrameList(client, flight).empty());
  CHECK(GetJson(client, "/v1/flights")["flights"].size() == 1);
  // A zip goes through the spool first.
  CheckProblem(client.Post("/v1/flights/" + flight + "/batch",
                           "PK" + std::string(options.max_file_bytes * 2, 'x'),
                           "application/zip"),
               507,
               "StorageFull");
  CHECK(client.Get("/healthz")->status == 200);
}

}  // namespace
}  // namespace freelsd
