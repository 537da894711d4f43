#include "tests/server/test_server.h"

#include <cstdlib>
#include <fstream>

#include <arpa/inet.h>
#include <doctest/doctest.h>
#include <opencv2/imgcodecs.hpp>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/server/openapi_check.h"

namespace freelsd {
namespace {

std::string TrainedModelText() {
  std::vector<TrainingSample> samples;
  cv::RNG random(1);
  for (int i = 0; i < 80; ++i) {
    const bool is_grass = i % 2 == 0;
    cv::Mat3b image(16, 16, is_grass ? cv::Vec3b(60, 140, 70) : cv::Vec3b(120, 120, 120));
    cv::Mat3b noise(image.size());
    random.fill(noise, cv::RNG::UNIFORM, 0, 40);
    samples.push_back({RegionFeatures(image + noise, cv::Mat1b(16, 16, 255), FeatureSet::kRgb),
                       is_grass,
                       "place " + std::to_string(i % 4)});
  }
  TrainingOptions options;
  options.feature_set = FeatureSet::kRgb;
  options.max_depths = {4};
  options.min_samples_per_branch = {2};
  options.num_trees = 10;
  options.num_folds = 2;
  return TrainClassifier(samples, "coloured noise, for tests", options).first.Serialize();
}

}  // namespace

std::filesystem::path TestModel() {
  static const TemporaryFolder kFolder;
  static const std::filesystem::path kPath = [] {
    std::filesystem::path file = kFolder.path() / "model.yml";
    std::ofstream(file) << TrainedModelText();
    return file;
  }();
  return kPath;
}

Config TestConfig(const std::filesystem::path& folder) {
  spdlog::set_level(spdlog::level::err);
  Config config;
  const StorageOptions storage = StorageAt(folder);
  config.data = storage.folder;
  config.database = storage.database_url;
  config.images = storage.images_folder;
  config.port = 0;
  config.model = TestModel();
  return config;
}

TestServer::TestServer(const Config& config) : app_(config), thread_([this] { app_.Run(); }) {
  httplib::Client client = Client();
  while (!client.Get("/healthz")) std::this_thread::sleep_for(std::chrono::milliseconds(5));
}

TestServer::~TestServer() {
  app_.Stop(std::chrono::seconds(30));
  thread_.join();
}

namespace {

httplib::Client ClientFor(int port) {
  httplib::Client client("127.0.0.1", port);
  client.set_keep_alive(true);
  client.set_read_timeout(30);
  client.set_tcp_nodelay(true);
  HoldAgainstContract(client);
  return client;
}

Config Changed(Config config, const std::function<void(Config&)>& change) {
  if (change) change(config);
  return config;
}

}  // namespace

httplib::Client TestServer::Client() const { return ClientFor(app_.port()); }

httplib::Client TestServer::EmergencyClient() const { return ClientFor(emergency_port()); }

FreshServer::FreshServer(const std::function<void(Config&)>& change)
    : server(Changed(TestConfig(folder.path() / "data"), change)), client(server.Client()) {}

RawConnection::RawConnection(int port) : descriptor_(::socket(AF_INET, SOCK_STREAM, 0)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  REQUIRE(::connect(descriptor_, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0);
  const timeval timeout{10, 0};
  ::setsockopt(descriptor_, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof(timeout));
}

RawConnection::~RawConnection() { ::close(descriptor_); }

void RawConnection::Send(const std::string& bytes) const {
  size_t num_sent = 0;
  while (num_sent < bytes.size()) {
    const ssize_t sent =
        ::send(descriptor_, bytes.data() + num_sent, bytes.size() - num_sent, MSG_NOSIGNAL);
    if (sent <= 0) return;
    num_sent += static_cast<size_t>(sent);
  }
}

std::string RawConnection::Receive() {
  char bytes[4096];
  while (true) {
    const size_t head = buffer_.find("\r\n\r\n");
    if (head != std::string::npos) {
      const size_t length = buffer_.find("Content-Length: ");
      const size_t size =
          head + 4 + (length < head ? std::strtoul(buffer_.c_str() + length + 16, nullptr, 10) : 0);
      if (buffer_.size() >= size) {
        std::string answer = buffer_.substr(0, size);
        buffer_.erase(0, size);
        return answer;
      }
    }
    const ssize_t num_read = ::recv(descriptor_, bytes, sizeof(bytes), 0);
    if (num_read <= 0) return {};
    buffer_.append(bytes, static_cast<size_t>(num_read));
  }
}

std::string RawConnection::ReceiveUntil(const std::string& text) {
  char bytes[4096];
  while (true) {
    const size_t end = buffer_.find(text);
    if (end != std::string::npos) {
      std::string received = buffer_.substr(0, end + text.size());
      buffer_.erase(0, end + text.size());
      return received;
    }
    const ssize_t num_read = ::recv(descriptor_, bytes, sizeof(bytes), 0);
    if (num_read <= 0) return {};
    buffer_.append(bytes, static_cast<size_t>(num_read));
  }
}

std::string NoiseImage(int seed, int width_px, int height_px, const char* type) {
  cv::Mat3b image(height_px, width_px);
  cv::RNG random(static_cast<uint64_t>(seed) + 1);
  random.fill(image, cv::RNG::UNIFORM, 0, 255);
  std::vector<uint8_t> bytes;
  cv::imencode(type, image, bytes);
  return std::string(bytes.begin(), bytes.end());
}

std::string NewFlight(httplib::Client& client, int width_px, int height_px) {
  const nlohmann::json request{{"name", "a test"},
                               {"camera",
                                {{"width_px", width_px},
                                 {"height_px", height_px},
                                 {"fx_px", 300.0},
                                 {"fy_px", 300.0},
                                 {"cx_px", width_px / 2.0},
                                 {"cy_px", height_px / 2.0}}}};
  const auto result = client.Post("/v1/flights", request.dump(), "application/json");
  REQUIRE(result);
  REQUIRE(result->status == 201);
  return nlohmann::json::parse(result->body).at("id");
}

std::string SomeMeta(int number) {
  return nlohmann::json{
      {"timestamp_us", 1700000000000000 + int64_t{250000} * number},
      {"position",
       {{"latitude_deg", 47.0 + number * 1e-5}, {"longitude_deg", 8.0}, {"altitude_m", 500.0}}},
      {"attitude", {{"roll_deg", 0.0}, {"pitch_deg", 0.0}, {"yaw_deg", 0.0}}},
      {"height_above_ground_m", 100.0}}
      .dump();
}

httplib::MultipartFormDataItems ImageAndMeta(const std::string& image, const std::string& meta) {
  return {{"image", image, "image.jpg", "image/jpeg"}, {"meta", meta, "", "application/json"}};
}

httplib::Result PutFrame(httplib::Client& client,
                         const std::string& flight,
                         const std::string& frame,
                         const std::string& image,
                         const std::string& meta) {
  return client.Put("/v1/flights/" + flight + "/frames/" + frame, ImageAndMeta(image, meta));
}

nlohmann::json FrameList(httplib::Client& client, const std::string& flight) {
  return GetJson(client, "/v1/flights/" + flight + "/frames").at("frames");
}

nlohmann::json GetJson(httplib::Client& client, const std::string& path) {
  const auto result = client.Get(path);
  REQUIRE(result);
  INFO(result->body);
  REQUIRE(result->status == 200);
  return nlohmann::json::parse(result->body);
}

nlohmann::json AwaitJob(httplib::Client& client, const std::string& job) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(5);
  nlohmann::json state;
  while (std::chrono::steady_clock::now() < deadline) {
    state = GetJson(client, "/v1/jobs/" + job);
    if (state["state"] != "queued" && state["state"] != "running") break;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return state;
}

void CheckProblem(const httplib::Result& result, int status, const std::string& code) {
  REQUIRE(result);
  INFO(result->body);
  CHECK(result->status == status);
  CHECK(result->get_header_value("Content-Type") == "application/problem+json");
  const nlohmann::json problem = nlohmann::json::parse(result->body, nullptr, false);
  REQUIRE(problem.is_object());
  CHECK(problem.value("status", 0) == status);
  CHECK(problem.value("code", "") == code);
  for (const char* key : {"type", "title", "detail", "errors", "retryable"}) {
    CHECK(problem.contains(key));
  }
}

}  // namespace freelsd
