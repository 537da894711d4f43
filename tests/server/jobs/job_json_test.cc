// What people who wait are told, over HTTP.
#include <doctest/doctest.h>

#include "tests/server/sample_flight.h"
#include "tests/storage/place.h"

namespace freelsd {
namespace {

void AwaitBatches(httplib::Client& client) {
  const nlohmann::json list = GetJson(client, "/v1/jobs");
  for (const auto& job : list["jobs"]) AwaitJob(client, job["id"]);
}

// Every state of the job that is seen until it is over.
std::vector<nlohmann::json> Watch(httplib::Client& client, const std::string& job) {
  std::vector<nlohmann::json> seen;
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(5);
  while (std::chrono::steady_clock::now() < deadline) {
    seen.push_back(GetJson(client, "/v1/jobs/" + job));
    const std::string state = seen.back()["state"];
    if (state != "queued" && state != "running") break;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return seen;
}

bool Begins(const nlohmann::json& text, const std::string& beginning) {
  return text.get<std::string>().rfind(beginning, 0) == 0;
}

// The longitudes and latitudes of a box around the sample flight's world.
void CheckArea(const nlohmann::json& area, const nlohmann::json& origin) {
  REQUIRE(area["type"] == "Polygon");
  const nlohmann::json& ring = area["coordinates"][0];
  REQUIRE(ring.size() == 5);
  CHECK(ring.front() == ring.back());
  for (const nlohmann::json& place : ring) {
    CHECK(std::abs(place[0].get<double>() - origin["longitude_deg"].get<double>()) < 0.05);
    CHECK(std::abs(place[1].get<double>() - origin["latitude_deg"].get<double>()) < 0.05);
  }
}

TEST_CASE(
    "job progress: a finish behind another flight's says for whom it waits, then what it does") {
  FreshServer fresh([](Config& config) { config.model = RealModel(); });
  const std::string first = PostSampleFlight(fresh.client, 0, kNumSampleFrames);
  const std::string second = PostSampleFlight(fresh.client, 0, kNumSampleFrames);
  AwaitBatches(fresh.client);
  const std::string first_job = Finish(fresh.client, first);
  REQUIRE(AwaitEvaluation(fresh.client, first_job));
  const std::vector<nlohmann::json> seen = Watch(fresh.client, Finish(fresh.client, second));
  const nlohmann::json origin = GetJson(fresh.client, "/v1/flights/" + second)["origin"];
  int num_waiting = 0;
  int num_with_area = 0;
  std::set<std::string> titles;
  for (const nlohmann::json& job : seen) {
    INFO(job.dump());
    titles.insert(job["stage_title"]);
    if (job["time_left_s"].is_number()) CHECK(job["time_left_s"] >= 0.0);
    if (job["waiting_for"].is_object()) {
      ++num_waiting;
      CHECK(job["state"] == "queued");
      CHECK(job["stage_title"] == "Waiting");
      CHECK(job["waiting_for"]["flight_id"] == first);
      CHECK(job["waiting_for"]["flight_name"] == "sample");
      CHECK(Begins(job["summary"], "Waiting for sample"));
      CHECK(job["started_at"].is_null());
    }
    if (job["state"] == "running") {
      CHECK(job["started_at"].is_string());
      CHECK(Begins(job["summary"], job["stage_title"]));
    }
    if (job["area"].is_object()) {
      ++num_with_area;
      CheckArea(job["area"], origin);
    }
  }
  CHECK(num_waiting > 0);
  CHECK(num_with_area > 0);
  CHECK(titles.contains("Comparing pairs of photographs"));
  const nlohmann::json& last = seen.back();
  CHECK(last["state"] == "done");
  CHECK(last["stage_title"] == "Done");
  CHECK(Begins(last["summary"], "Done: "));
  CHECK(last["time_left_s"].is_null());
  CHECK(last["area"].is_null());
  CHECK(last["started_at"].is_string());
}

TEST_CASE("job progress: the second evaluation of a kind knows its time from the first one's") {
  FreshServer fresh([](Config& config) { config.model = RealModel(); });
  const std::string first = PostSampleFlight(fresh.client, 0, kNumSampleFrames);
  REQUIRE(AwaitJob(fresh.client, Finish(fresh.client, first))["state"] == "done");
  const std::string second = PostSampleFlight(fresh.client, 0, kNumSampleFrames);
  AwaitBatches(fresh.client);
  const std::string job = Finish(fresh.client, second);
  REQUIRE(AwaitEvaluation(fresh.client, job));
  const nlohmann::json running = GetJson(fresh.client, "/v1/jobs/" + job);
  CHECK(running["time_left_s"].is_number());
  CHECK(running["summary"].get<std::string>().ends_with(" left"));
}

TEST_CASE("job progress: a finish waits for its photographs first, for a time that was measured") {
  FreshServer fresh([](Config& config) { config.model = RealModel(); });
  const std::string flight = PostSampleFlight(fresh.client, 0, kNumSampleFrames);
  int num_waiting = 0;
  int num_with_time = 0;
  for (const nlohmann::json& job : Watch(fresh.client, Finish(fresh.client, flight))) {
    if (!Begins(job["summary"], "Waiting until the photographs are processed")) continue;
    INFO(job.dump());
    ++num_waiting;
    if (job["summary"] != "Waiting until the photographs are processed") ++num_with_time;
    CHECK(job["waiting_for"].is_null());
    // How long the evaluation itself takes is not known yet.
    CHECK(job["time_left_s"].is_null());
  }
  CHECK(num_waiting > 0);
  CHECK(num_with_time > 0);
}

TEST_CASE("job progress: a job that ran before a restart waits, and does not tell old times") {
  const TemporaryFolder folder;
  {
    // As a killed server leaves it.
    Storage storage(StorageAt(folder.path() / "data"));
    FlightRow flight;
    flight.id = "f-1";
    flight.request_json = ParseFlightRequest(R"({"name":"x"})").canonical_json;
    // No frame will come, so the job stays.
    storage.flights.Insert(flight);
    JobRow job;
    job.id = "j-1";
    job.kind = "finish";
    job.flight_id = "f-1";
    job.state = JobState::kRunning;
    job.progress_ratio = 0.7;
    job.stage = "stereo";
    storage.jobs.Insert(job);
  }
  const TestServer server(TestConfig(folder.path() / "data"));
  httplib::Client client = server.Client();
  const nlohmann::json job = GetJson(client, "/v1/jobs/j-1");
  REQUIRE(job["state"] == "running");
  CHECK(job["stage_title"] == "Waiting");
  CHECK(job["summary"] == "Waiting for its turn");
  CHECK(job["time_left_s"].is_null());
  CHECK(job["started_at"].is_null());
  CHECK(job["area"].is_null());
}

}  // namespace
}  // namespace freelsd
