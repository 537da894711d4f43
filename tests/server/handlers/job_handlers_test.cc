// Jobs that are cancelled, and what a finish takes together.
#include <doctest/doctest.h>

#include "tests/server/sample_flight.h"

namespace freelsd {
namespace {

TEST_CASE("jobs: a queued job is cancelled, then forgotten, and its frames stay") {
  constexpr int kNumImages = 40;
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  httplib::MultipartFormDataItems items;
  std::string poses = "image,latitude_deg,longitude_deg,altitude_m\n";
  for (int i = 0; i < kNumImages; ++i) {
    const std::string name = std::to_string(i) + ".jpg";
    items.push_back({"images", NoiseImage(i), name, "image/jpeg"});
    poses += name + ",47.00" + std::to_string(100 + i) + ",8.0,500\n";
  }
  items.push_back({"poses", poses, "poses.csv", "text/csv"});
  REQUIRE(fresh.client.Post("/v1/flights/" + flight + "/batch", items)->status == 202);
  // Waits for the batch, so it is queued.
  const std::string job = Finish(fresh.client, flight);
  const auto cancelled = fresh.client.Delete("/v1/jobs/" + job);
  REQUIRE(cancelled);
  CHECK(cancelled->status == 200);
  CHECK(nlohmann::json::parse(cancelled->body)["state"] == "cancelled");
  CHECK(AwaitJob(fresh.client, job)["state"] == "cancelled");
  CHECK(FrameList(fresh.client, flight).size() == kNumImages);
  CHECK(fresh.client.Delete("/v1/jobs/" + job)->status == 204);
  CheckProblem(fresh.client.Get("/v1/jobs/" + job), 404, "NoSuchJob");
}

TEST_CASE("jobs: more flights than may be in memory are all finished") {
  constexpr int kNumFlights = 3;
  FreshServer fresh([](Config& config) { config.max_num_open_flights = 1; });
  std::vector<std::string> jobs;
  for (int flight_number = 0; flight_number < kNumFlights; ++flight_number) {
    const std::string flight = NewFlight(fresh.client);
    for (int i = 0; i < 3; ++i) {
      const auto sent =
          PutFrame(fresh.client, flight, std::to_string(i), NoiseImage(i), SomeMeta(i));
      CHECK(sent->status == 201);
    }
    jobs.push_back(Finish(fresh.client, flight));
  }
  for (const std::string& job : jobs) CHECK(AwaitJob(fresh.client, job)["state"] == "done");
}

TEST_CASE("jobs: an evaluation that runs is cancelled, and the next finish does it whole") {
  FreshServer fresh([](Config& config) { config.model = RealModel(); });
  const std::string flight = PostSampleFlight(fresh.client, 0, kNumSampleFrames);
  const std::string job = Finish(fresh.client, flight);
  REQUIRE(AwaitEvaluation(fresh.client, job));
  CHECK(fresh.client.Delete("/v1/jobs/" + job)->status == 200);
  CHECK(AwaitJob(fresh.client, job)["state"] == "cancelled");
  // A cancelled evaluation stores nothing.
  CHECK(SiteIds(fresh.client, flight).empty());
  const std::string again = Finish(fresh.client, flight);
  CHECK(again != job);
  CHECK(AwaitJob(fresh.client, again)["state"] == "done");
  CHECK(GetJson(fresh.client, "/v1/jobs/" + job)["state"] == "cancelled");
  CHECK_FALSE(SiteIds(fresh.client, flight).empty());
}

void AwaitBatches(httplib::Client& client) {
  const nlohmann::json list = GetJson(client, "/v1/jobs");
  for (const auto& job : list["jobs"]) AwaitJob(client, job["id"]);
}

// Where the flight's sites are, and how good.
nlohmann::json Findings(httplib::Client& client, const std::string& flight) {
  nlohmann::json findings = nlohmann::json::array();
  const nlohmann::json sites =
      GetJson(client, "/v1/flights/" + flight + "/sites?include=superseded");
  for (const auto& site : sites["features"]) {
    const auto& properties = site["properties"];
    findings.push_back({site["geometry"], properties["verdict"], properties["score"]});
  }
  return findings;
}

TEST_CASE("jobs: a finish decides frames that lacked neighbours anew, as if all came together") {
  FreshServer fresh([](Config& config) { config.model = RealModel(); });
  const std::string whole = PostSampleFlight(fresh.client, 0, kNumSampleFrames);
  REQUIRE(AwaitJob(fresh.client, Finish(fresh.client, whole))["state"] == "done");
  REQUIRE_FALSE(Findings(fresh.client, whole).empty());

  // Alone, the first has no neighbour that tells its height above ground.
  const std::string cut = PostSampleFlight(fresh.client, 0, 1);
  AwaitBatches(fresh.client);
  CHECK(FrameList(fresh.client, cut)[0]["state"] == "rejected");
  PostSampleFrames(fresh.client, cut, 1, kNumSampleFrames);
  REQUIRE(AwaitJob(fresh.client, Finish(fresh.client, cut))["state"] == "done");
  const nlohmann::json frames = GetJson(fresh.client, "/v1/flights/" + cut)["frames"];
  CHECK(frames["processed"] == kNumSampleFrames);
  CHECK(frames["rejected"] == 0);
  CHECK(Findings(fresh.client, cut) == Findings(fresh.client, whole));
}

}  // namespace
}  // namespace freelsd
