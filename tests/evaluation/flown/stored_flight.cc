#include "tests/evaluation/flown/stored_flight.h"

#include <chrono>
#include <sstream>
#include <stdexcept>
#include <thread>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "server/http/http_library.h"
#include "tests/synthetic/flight_files.h"

namespace freelsd {
namespace {

using Json = nlohmann::json;

// Bodies stay well below what a service takes at once.
constexpr size_t kFramesPerBatch = 10;
constexpr auto kPollPeriod = std::chrono::milliseconds(200);
constexpr int kTimeoutS = 300;

Json Answer(const httplib::Result& result, const std::string& what, int wanted_status) {
  if (!result) throw std::runtime_error(what + ": " + httplib::to_string(result.error()));
  if (result->status != wanted_status) {
    throw std::runtime_error(what + ": status " + std::to_string(result->status) + ", " +
                             result->body);
  }
  return result->body.empty() ? Json() : Json::parse(result->body);
}

class Service {
 public:
  explicit Service(const std::string& url) : client_(url) { client_.set_read_timeout(kTimeoutS); }

  Json Get(const std::string& path) { return Answer(client_.Get(path), "GET " + path, 200); }
  Json Post(const std::string& path, const std::string& body, int wanted_status) {
    return Answer(client_.Post(path, body, "application/json"), "POST " + path, wanted_status);
  }
  Json Post(const std::string& path, const httplib::MultipartFormDataItems& items) {
    return Answer(client_.Post(path, items), "POST " + path, 202);
  }
  void Delete(const std::string& path) { client_.Delete(path); }

  void Await(const std::string& job) {
    for (;;) {
      const Json status = Get("/v1/jobs/" + job);
      const std::string state = status.at("state");
      if (state == "done") return;
      if (state == "failed" || state == "cancelled") throw std::runtime_error(status.dump());
      std::this_thread::sleep_for(kPollPeriod);
    }
  }

 private:
  httplib::Client client_;
};

// Header and lines [begin, end) of a table: a batch must not name images that are not in it.
std::string LinesOf(const std::string& table, size_t begin, size_t end) {
  std::istringstream lines(table);
  std::string part, line;
  std::getline(lines, line);
  part = line + "\n";
  for (size_t i = 0; std::getline(lines, line); ++i) {
    if (i >= begin && i < end) part += line + "\n";
  }
  return part;
}

void SendFrames(Service& service, const std::string& flight, const Scenario& scenario) {
  const std::string poses = PosesCsv(scenario.world, scenario.exposures);
  const size_t num_frames = scenario.frames.size();
  for (size_t begin = 0; begin < num_frames; begin += kFramesPerBatch) {
    const size_t end = std::min(begin + kFramesPerBatch, num_frames);
    httplib::MultipartFormDataItems items{
        {"poses", LinesOf(poses, begin, end), "poses.csv", "text/csv"}};
    for (size_t i = begin; i < end; ++i) {
      std::vector<uchar> bytes;
      cv::imencode(".png", scenario.frames[i].image, bytes);
      items.push_back(
          {"images", std::string(bytes.begin(), bytes.end()), scenario.frames[i].id, "image/png"});
    }
    const Json job = service.Post("/v1/flights/" + flight + "/batch", items);
    service.Await(job.at("id"));
  }
}

}  // namespace

void StoreOverHttp(const std::string& url, const Scenario& scenario) {
  Service service(url);
  const std::string request = FlightJson("world " + std::to_string(scenario.world.seed),
                                         scenario.rig.camera,
                                         scenario.aircraft.profile);
  const std::string flight = service.Post("/v1/flights", request, 201).at("id");
  SendFrames(service, flight, scenario);
  service.Await(service.Post("/v1/flights/" + flight + "/finish", "", 202).at("id"));
  service.Delete("/v1/flights/" + flight);
}

}  // namespace freelsd
