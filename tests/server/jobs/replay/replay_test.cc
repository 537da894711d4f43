// The digests of sites: the same for the same evidence, however it was sent, and found again by a
// replay.
#include <filesystem>
#include <map>

#include <doctest/doctest.h>

#include "tests/server/sample_flight.h"

namespace freelsd {
namespace {

// By the end of the site's id.
std::map<std::string, std::string> Digests(httplib::Client& client, const std::string& flight) {
  std::map<std::string, std::string> digests;
  const nlohmann::json sites = GetJson(client, "/v1/flights/" + flight + "/sites");
  for (const auto& feature : sites["features"]) {
    const nlohmann::json& properties = feature["properties"];
    const std::string id = properties["id"];
    digests[id.substr(flight.size())] = properties["evidence_digest"];
  }
  return digests;
}

std::string Replay(httplib::Client& client, const std::string& flight) {
  const auto result = client.Post("/v1/flights/" + flight + "/replay");
  REQUIRE(result);
  REQUIRE(result->status == 202);
  return nlohmann::json::parse(result->body)["id"];
}

TEST_CASE("replay: digests are the same for other batches, and are found again") {
  FreshServer fresh([](Config& config) { config.model = RealModel(); });
  httplib::Client& client = fresh.client;
  const std::string whole = PostSampleFlight(client, 0, kNumSampleFrames);
  CHECK(AwaitJob(client, Finish(client, whole))["state"] == "done");
  const std::string parts = PostSampleFlight(client, 0, 7);
  PostSampleFrames(client, parts, 7, 9);
  PostSampleFrames(client, parts, 9, kNumSampleFrames);
  CHECK(AwaitJob(client, Finish(client, parts))["state"] == "done");
  const auto digests = Digests(client, whole);
  REQUIRE_FALSE(digests.empty());
  for (const auto& [name, digest] : digests) CHECK(digest.size() == 64);
  CHECK(Digests(client, parts) == digests);

  const nlohmann::json before = GetJson(client, "/v1/flights/" + whole + "/sites");
  const std::string job = Replay(client, whole);
  CHECK(Replay(client, whole) == job);
  const nlohmann::json replayed = AwaitJob(client, job);
  CHECK(replayed["state"] == "done");
  INFO(replayed.dump());
  CHECK(replayed["detail"]["num_equal"] == digests.size());
  for (const auto& site : replayed["detail"]["sites"]) {
    CHECK(site["is_equal"] == true);
    const std::string id = site["site_id"];
    CHECK(site["replayed"] == digests.at(id.substr(whole.size())));
  }
  // Only ages go on.
  const nlohmann::json after = GetJson(client, "/v1/flights/" + whole + "/sites");
  CHECK(after["features"].size() == before["features"].size());
  for (size_t i = 0; i < after["features"].size(); ++i) {
    CHECK(after["features"][i]["properties"]["updated_at"] ==
          before["features"][i]["properties"]["updated_at"]);
  }
}

TEST_CASE("replay: other options and fewer photographs are other evidence") {
  FreshServer fresh([](Config& config) { config.model = RealModel(); });
  httplib::Client& client = fresh.client;
  const std::string all = PostSampleFlight(client, 0, kNumSampleFrames);
  CHECK(AwaitJob(client, Finish(client, all))["state"] == "done");
  const std::string fewer = PostSampleFlight(client, 0, kNumSampleFrames - 1);
  CHECK(AwaitJob(client, Finish(client, fewer))["state"] == "done");
  const std::string other = NewSampleFlight(client, {}, {{"safety_margin_m", 2.5}});
  PostSampleFrames(client, other, 0, kNumSampleFrames);
  CHECK(AwaitJob(client, Finish(client, other))["state"] == "done");
  const auto digests = Digests(client, all);
  const auto of_fewer = Digests(client, fewer);
  const auto of_other = Digests(client, other);
  REQUIRE_FALSE(of_fewer.empty());
  REQUIRE_FALSE(of_other.empty());
  for (const auto& [name, digest] : digests) {
    if (of_fewer.contains(name)) CHECK(of_fewer.at(name) != digest);
    if (of_other.contains(name)) CHECK(of_other.at(name) != digest);
  }
}

// Cuts the image file of a frame.
void DamageImage(httplib::Client& client,
                 const std::filesystem::path& data,
                 const std::string& flight,
                 const std::string& frame_id) {
  for (const nlohmann::json& frame : FrameList(client, flight)) {
    if (frame["id"] != frame_id) continue;
    const std::string sha256 = frame["sha256"];
    std::filesystem::resize_file(data / "images" / sha256.substr(0, 2) / sha256, 1000);
    return;
  }
  FAIL("there is no such frame");
}

TEST_CASE("replay: one that fails names the photograph") {
  FreshServer fresh;
  httplib::Client& client = fresh.client;
  const std::string flight = PostSampleFlight(client, 0, 3);
  REQUIRE(AwaitJob(client, Finish(client, flight))["state"] == "done");
  const std::string frame = FrameList(client, flight)[1]["id"];
  DamageImage(client, fresh.folder.path() / "data", flight, frame);
  const nlohmann::json failed = AwaitJob(client, Replay(client, flight));
  CHECK(failed["state"] == "failed");
  CHECK(failed["detail"]["message"].get<std::string>().find("the photograph " + frame + ": ") == 0);
}

TEST_CASE("replay: without a finished evaluation there is nothing to repeat") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  CheckProblem(fresh.client.Post("/v1/flights/" + flight + "/replay"), 409, "Conflict");
  CheckProblem(fresh.client.Post("/v1/flights/none/replay"), 404, "NoSuchFlight");
}

}  // namespace
}  // namespace freelsd
