// Images that are removed to make room, and what stays.
#include <doctest/doctest.h>

#include "tests/server/test_server.h"

namespace freelsd {
namespace {

int NumFiles(const std::filesystem::path& folder) {
  int num_files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) ++num_files;
  }
  return num_files;
}

TEST_CASE("retention: images beyond the settings go, the flight stays readable and is over") {
  const TemporaryFolder folder;
  std::string flight;
  {
    const TestServer server(TestConfig(folder.path() / "data"));
    httplib::Client client = server.Client();
    flight = NewFlight(client);
    for (int i = 0; i < 3; ++i) {
      PutFrame(client, flight, std::to_string(i), NoiseImage(i), SomeMeta(i));
    }
    const auto finish = client.Post("/v1/flights/" + flight + "/finish");
    CHECK(AwaitJob(client, nlohmann::json::parse(finish->body)["id"])["state"] == "done");
  }
  Config config = TestConfig(folder.path() / "data");
  config.max_stored_image_bytes = 1000;
  const TestServer server(config);
  httplib::Client client = server.Client();
  const std::string path = "/v1/flights/" + flight;
  for (int i = 0; i < 400 && !GetJson(client, path).value("has_retired_images", false); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  CHECK(GetJson(client, path)["has_retired_images"] == true);
  CHECK(FrameList(client, flight).size() == 3);
  // The server commits the flag first and removes the files then: a crash in between loses no image
  // that a flight still counts on.
  const std::filesystem::path images = folder.path() / "data/images";
  for (int i = 0; i < 400 && NumFiles(images) > 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  CHECK(NumFiles(images) == 0);
  // No more can come of it, and asking for an evaluation takes nothing away.
  CheckProblem(PutFrame(client, flight, "new", NoiseImage(9), SomeMeta(9)), 409, "Conflict");
  const auto finish = client.Post(path + "/finish");
  CHECK(nlohmann::json::parse(finish->body)["state"] == "done");
}

}  // namespace
}  // namespace freelsd
