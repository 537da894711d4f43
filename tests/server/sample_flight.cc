#include "tests/server/sample_flight.h"

#include <chrono>

#include <doctest/doctest.h>
#include <opencv2/imgcodecs.hpp>

#include "tests/synthetic/flight_files.h"
#include "tests/synthetic/renderer.h"

namespace freelsd {
namespace {

constexpr int kWidthPx = 564;
constexpr int kHeightPx = 360;

struct SampleFlight {
  std::string request;
  std::vector<std::string> names;
  std::vector<std::string> images;
  std::string poses;
};

SampleFlight Render() {
  WorldOptions world_options;
  world_options.seed = 1;
  FlightOptions flight_options;
  flight_options.num_frames = kNumSampleFrames;
  const World world = MakeFarmland(world_options);
  const auto exposures = PlanFlight(flight_options, world.wind_in_world);
  const Camera camera = PaperCamera(kWidthPx, kHeightPx);
  const Renderer renderer(world);
  SampleFlight flight;
  flight.request = FlightJson("sample", camera, "small");
  flight.poses = PosesCsv(world, exposures);
  for (size_t i = 0; i < exposures.size(); ++i) {
    const Rigid3d world_from_camera = WorldFromBody(exposures[i].truth) * Rig{}.body_from_camera;
    std::vector<uint8_t> bytes;
    cv::imencode(
        ".jpg", renderer.Render(camera, world_from_camera, {}, static_cast<int>(i)), bytes);
    flight.names.push_back(exposures[i].image);
    flight.images.emplace_back(bytes.begin(), bytes.end());
  }
  return flight;
}

const SampleFlight& Sample() {
  static const SampleFlight kFlight = Render();
  return kFlight;
}

void PostFrames(httplib::Client& client,
                const std::string& flight,
                const std::string& poses,
                int begin,
                int end,
                const std::string& prefix = "") {
  httplib::MultipartFormDataItems items{{"poses", poses, "poses.csv", "text/csv"}};
  for (int i = begin; i < end; ++i) {
    const size_t index = static_cast<size_t>(i);
    items.push_back(
        {"images", Sample().images[index], prefix + Sample().names[index], "image/jpeg"});
  }
  const auto batch = client.Post("/v1/flights/" + flight + "/batch", items);
  REQUIRE(batch);
  INFO(batch->body);
  REQUIRE(batch->status == 202);
}

std::string PostFlight(httplib::Client& client, const nlohmann::json& request) {
  const auto result = client.Post("/v1/flights", request.dump(), "application/json");
  REQUIRE(result);
  INFO(result->body);
  REQUIRE(result->status == 201);
  return nlohmann::json::parse(result->body).at("id");
}

}  // namespace

std::filesystem::path RealModel() {
  return std::filesystem::path(FREELSD_SOURCE_DIR) / "engine/ground_kind/ground_kind.onnx";
}

// The header and the lines of these frames: a batch must not name images that are not there.
std::string SamplePoses(int begin, int end, const std::string& prefix) {
  std::istringstream lines(Sample().poses);
  std::string poses, line;
  for (int i = -1; std::getline(lines, line); ++i) {
    if (i >= 0 && (i < begin || i >= end)) continue;
    if (i >= 0) line.insert(line.find(Sample().names[static_cast<size_t>(i)]), prefix);
    poses += line + "\n";
  }
  return poses;
}

std::string NewSampleFlight(httplib::Client& client,
                            const nlohmann::json& options,
                            const nlohmann::json& aircraft) {
  nlohmann::json request = nlohmann::json::parse(Sample().request);
  if (!options.is_null()) request["options"] = options;
  if (!aircraft.is_null()) request["aircraft"] = aircraft;
  return PostFlight(client, request);
}

void PostSampleFrames(httplib::Client& client,
                      const std::string& flight,
                      int begin,
                      int end,
                      const std::string& prefix) {
  PostFrames(client, flight, SamplePoses(begin, end, prefix), begin, end, prefix);
}

std::string PostSampleFlight(httplib::Client& client, int begin, int end) {
  std::string flight = NewSampleFlight(client);
  PostSampleFrames(client, flight, begin, end);
  return flight;
}

std::string PostSampleFlightWithNamedDatum(httplib::Client& client) {
  nlohmann::json request = nlohmann::json::parse(Sample().request);
  request.erase("altitude_datum");
  request["aircraft"] = {{"profile", "small"}, {"ground_roll_m", 2000.0}};
  std::string flight = PostFlight(client, request);
  std::string poses = Sample().poses;
  const std::string column = "altitude_m";
  poses.replace(poses.find(column), column.size(), "alt_amsl_m");
  PostFrames(client, flight, poses, 0, kNumSampleFrames);
  return flight;
}

std::string Finish(httplib::Client& client, const std::string& flight) {
  const auto finish = client.Post("/v1/flights/" + flight + "/finish");
  REQUIRE(finish);
  REQUIRE(finish->status == 202);
  return nlohmann::json::parse(finish->body).at("id");
}

bool AwaitEvaluation(httplib::Client& client, const std::string& job) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(2);
  while (std::chrono::steady_clock::now() < deadline) {
    const std::string state = GetJson(client, "/v1/jobs/" + job)["state"];
    if (state != "queued") return state == "running";
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

nlohmann::json SiteIds(httplib::Client& client, const std::string& flight) {
  nlohmann::json ids = nlohmann::json::array();
  const nlohmann::json sites =
      GetJson(client, "/v1/flights/" + flight + "/sites?include=superseded");
  for (const auto& site : sites["features"]) {
    ids.push_back(site["properties"]["id"]);
  }
  return ids;
}

}  // namespace freelsd
