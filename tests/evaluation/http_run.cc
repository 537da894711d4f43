#include "tests/evaluation/http_run.h"

#include <chrono>
#include <limits>
#include <stdexcept>
#include <thread>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "api/plan_json.h"
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

  void Await(const std::string& job, const Progress& progress) {
    for (;;) {
      const Json status = Get("/v1/jobs/" + job);
      const std::string state = status.at("state");
      if (state == "done") return;
      if (state == "failed" || state == "cancelled") throw std::runtime_error(status.dump());
      progress(status.value("progress", 0.0), state);
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

void SendFrames(Service& service,
                const std::string& flight,
                const Scenario& scenario,
                const Progress& progress) {
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
    service.Await(job.at("id"), progress);
  }
}

Eigen::Vector3d PlaceOf(const Json& position, const LocalFrame& frame) {
  const double altitude = position.size() > 2 ? position.at(2).get<double>() : 0.0;
  return frame.WorldFromGeo({position.at(1).get<double>(), position.at(0).get<double>(), altitude});
}

std::vector<Eigen::Vector3d> CornersOf(const Json& polygon, const LocalFrame& frame) {
  std::vector<Eigen::Vector3d> corners;
  const Json& ring = polygon.at("coordinates").at(0);
  for (size_t i = 0; i + 1 < ring.size(); ++i) corners.push_back(PlaceOf(ring.at(i), frame));
  return corners;
}

// Final and circle follow from the touchdown and a few numbers.
Approach ApproachOf(const Json& json, const Eigen::Vector3d& touchdown) {
  Approach approach;
  approach.touchdown_in_world = touchdown;
  approach.heading = RadFromDeg(json.at("heading_deg").get<double>());
  approach.approach_distance = json.at("distance_m").get<double>();
  approach.approach_height = json.at("height_m").get<double>();
  approach.loiter_radius = json.at("loiter_radius_m").get<double>();
  const bool is_left = json.at("loiter_direction") == "left";
  approach.loiter_direction = is_left ? LoiterDirection::kLeft : LoiterDirection::kRight;
  const Eigen::Vector2d forward = DirectionOf(approach.heading);
  const Eigen::Vector2d left(-forward.y(), forward.x());
  const Eigen::Vector2d start = touchdown.head<2>() - approach.approach_distance * forward;
  const Eigen::Vector2d center = start + (is_left ? 1.0 : -1.0) * approach.loiter_radius * left;
  const double height = touchdown.z() + approach.approach_height;
  approach.approach_start_in_world << start, height;
  approach.loiter_center_in_world << center, height;
  return approach;
}

Verdict VerdictNamed(const std::string& name) {
  for (const Verdict verdict : {Verdict::kLandable, Verdict::kUnverified, Verdict::kRejected}) {
    if (name == NameOf(verdict)) return verdict;
  }
  throw std::runtime_error("unknown verdict " + name);
}

RejectReason ReasonNamed(const std::string& name) {
  for (int i = 0; i <= static_cast<int>(RejectReason::kNoTerrain); ++i) {
    if (name == NameOf(static_cast<RejectReason>(i))) return static_cast<RejectReason>(i);
  }
  throw std::runtime_error("unknown reason " + name);
}

Region RegionOf(const Json& polygon, const Json& properties, const LocalFrame& frame) {
  Region region;
  region.corners_in_world = CornersOf(polygon, frame);
  region.grade = properties.at("grade").is_number() ? properties.at("grade").get<double>() : 0.0;
  region.area_m2 = properties.at("area_m2").get<double>();
  region.num_observations = properties.at("num_observations").get<int>();
  region.num_grass_observations = properties.at("num_grass_observations").get<int>();
  return region;
}

Site SiteOf(const Json& feature, const LocalFrame& frame) {
  const Json& properties = feature.at("properties");
  Site site;
  site.region = RegionOf(properties.at("footprint"), properties, frame);
  const Json& region_id = properties.at("region_id");
  site.region.id = region_id.is_null() ? kNoRegion : region_id.get<int>();
  Plan& plan = site.plan;
  plan.verdict = VerdictNamed(properties.at("verdict"));
  if (plan.verdict == Verdict::kRejected) {
    plan.reject_reason = ReasonNamed(properties.at("reject_reason"));
  }
  plan.reject_detail = properties.value("reject_detail", "");
  plan.touchdown_in_world = PlaceOf(feature.at("geometry").at("coordinates"), frame);
  const Json& distance = properties.at("hazard_distance_m");
  plan.hazard_distance = distance.is_number() ? distance.get<double>() : 0.0;
  if (properties.at("approach").is_null()) return site;
  plan.approach = ApproachOf(properties.at("approach"), plan.touchdown_in_world);
  const Json& unseen = properties.at("unseen_ratio");
  plan.approach->unseen_ratio = unseen.is_number() ? unseen.get<double>() : 0.0;
  return site;
}

double ElapsedS(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

EngineRun RunOverHttp(const std::string& url, const Scenario& scenario, const Progress& progress) {
  const auto start = std::chrono::steady_clock::now();
  Service service(url);
  const World& world = scenario.world;
  const std::string request = FlightJson(
      "world " + std::to_string(world.seed), scenario.rig.camera, scenario.aircraft.profile);
  const std::string flight = service.Post("/v1/flights", request, 201).at("id");
  SendFrames(service, flight, scenario, progress);
  EngineRun run;
  run.frontend_seconds = ElapsedS(start);
  service.Await(service.Post("/v1/flights/" + flight + "/finish", "", 202).at("id"), progress);
  run.total_seconds = ElapsedS(start);
  const LocalFrame frame(world.origin);
  const Json sites = service.Get("/v1/flights/" + flight + "/sites");
  for (const Json& feature : sites.at("features")) {
    run.evaluation.sites.push_back(SiteOf(feature, frame));
  }
  const Json regions = service.Get("/v1/flights/" + flight + "/regions");
  for (const Json& feature : regions.at("features")) {
    run.regions.push_back(RegionOf(feature.at("geometry"), feature.at("properties"), frame));
    run.regions.back().id = feature.at("properties").at("id").get<int>();
  }
  service.Delete("/v1/flights/" + flight);
  return run;
}

}  // namespace freelsd
