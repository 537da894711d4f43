#include "server/app.h"

#include <cstdlib>
#include <fstream>
#include <iterator>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "api/import/import.h"
#include "server/intake/intake.h"
#include "server/jobs/jobs.h"
#include "server/routes.h"

namespace freelsd {
namespace {

GroundModelFile ReadModel(const std::filesystem::path& path, const std::string& advice) {
  try {
    return ReadGroundModel(path);
  } catch (const std::invalid_argument& error) {
    throw ConfigError("the model of the ground: " + std::string(error.what()) + "; " + advice);
  }
}

GroundModels ReadModels(const Config& config) {
  const GroundModelFile kinds =
      ReadModel(config.model.empty() ? BesideProgram("ground_kind.onnx") : config.model,
                "give its path with --model");
  const GroundModelFile paper = ReadModel(BesideProgram("paper_model.yml"), "install it there");
  return {kinds.model, paper.model, Sha256Hex(kinds.bytes), Sha256Hex(paper.bytes)};
}

Page ReadPageFiles(const Config& config) {
  Page page = ReadPage(config.page.empty() ? BesideProgram("web") : config.page);
  if (!page.contains("/"))
    spdlog::warn("the page was not found; the service runs without the page");
  return page;
}

// As main.cc's for what a later start may mend.
constexpr int kExitLostLease = 75;

// Emergency answers take milliseconds, and whole requests alone reach these threads.
constexpr int kNumEmergencyThreads = 32;

StorageOptions StorageOf(const Config& config) {
  StorageOptions options;
  options.folder = config.data;
  options.database_url = config.database;
  options.images_folder = config.images;
  options.is_shared = config.role.has_value();
  options.is_worker = config.role && *config.role != Role::kApi;
  options.log_notice = [](const std::string& text) { spdlog::warn("notice: {}", text); };
  return options;
}

FollowOptions FollowOptionsOf(const Config& config) {
  FollowOptions options;
  options.url = config.follow;
  options.area_text = config.area;
  try {
    options.area = ParseArea(config.area);
  } catch (const ApiError& error) {
    throw ConfigError(std::string("--area: ") + error.what());
  }
  if (!config.follow_token_file.empty()) options.token = ReadFollowToken(config.follow_token_file);
  return options;
}

HttpOptions OptionsOf(const Config& config, Listener listener) {
  const bool is_main = listener == Listener::kMain;
  HttpOptions options;
  options.rules.allowed_hosts = config.allowed_hosts;
  options.rules.takes_large_bodies = is_main;
  // Long computations, and those that wait for them, take no thread from the others.
  options.num_threads =
      is_main ? config.num_http_threads + LongQueues::MaxNumThreads() : kNumEmergencyThreads;
  return options;
}

HttpServer::Handler HandlerFor(Service& service, Listener listener) {
  return [&service, listener](
             const httplib::Request& request, BodyReader& body, httplib::Response& response) {
    Serve(service, listener, request, body, response);
  };
}

// Of recall's memory.
CacheSizes CacheSizesOf(const Config& config) {
  const size_t num_bytes = static_cast<size_t>(config.recall_cache_mib) << 20;
  return {num_bytes / 2, num_bytes / 3, num_bytes / 6};
}

}  // namespace

App::App(const Config& config)
    : config_(config),
      base_map_(config_),
      storage_(StorageOf(config_)),
      maps_(CacheSizesOf(config_)),
      intake_(config_, storage_, events_),
      alternates_(storage_, maps_, events_, static_cast<size_t>(config_.num_alternates)),
      service_(intake_, maps_, alternates_, base_map_),
      http_(OptionsOf(config_, Listener::kMain), HandlerFor(service_, Listener::kMain)),
      port_(http_.Bind(config_.host, config_.port)),
      sharing_(storage_, events_, CallsOfSharing()) {
  service_.page = ReadPageFiles(config_);
  events_.CallOnNews(http_.NewsCall());
  intake_.streams.release(MaxNumStreams(config_) - kLimits.concurrency.max_num_streams);
  intake_.on_new_pose = [this](const std::string& flight_id) { alternates_.Wake(flight_id); };
  intake_.wake_worker = [this] {
    if (worker_) worker_->Wake();
  };
  if (!config_.token_file.empty()) service_.tokens = TokenList::Read(config_.token_file);
  if (config_.emergency) {
    emergency_http_ = std::make_unique<HttpServer>(OptionsOf(config_, Listener::kEmergency),
                                                   HandlerFor(service_, Listener::kEmergency));
    emergency_port_ = emergency_http_->Bind(config_.emergency->host, config_.emergency->port);
  }
  if (config_.role != Role::kApi) worker_.emplace(service_, ReadModels(config_));
  sharing_.Start();
  if (!config_.follow.empty()) BeginToFollow();
}

void App::BeginToFollow() {
  follower_ = std::make_unique<Follower>(
      storage_, maps_, service_.copy, FollowOptionsOf(config_), [this](const MergeResult& merged) {
        for (const SiteRow& site : merged.sites) {
          events_.Publish("site",
                          site.flight_id,
                          nlohmann::json{{"id", site.id}, {"flight_id", site.flight_id}}.dump());
        }
        alternates_.WakeAll();
      });
  follower_->Start();
}

SharingCalls App::CallsOfSharing() {
  SharingCalls calls;
  calls.on_work = [this] {
    if (worker_) worker_->Wake();
  };
  calls.on_event = [this](const SharedEvent& event) {
    events_.Relay(event.type, event.flight_id, event.data);
  };
  calls.on_changed_sites = [this] { alternates_.WakeAll(); };
  // What its threads are doing is another server's work by now, and a new start is clean.
  calls.on_lost_lease = [] {
    spdlog::critical("this server's lease was over, and another server has its flights: it ends");
    std::_Exit(kExitLostLease);
  };
  return calls;
}

void App::Run() {
  // Alternates are for emergencies too: before others give way to these.
  alternates_.Start();
  std::thread emergency;
  if (emergency_http_) {
    emergency = std::thread([this] { emergency_http_->Run(); });
    GiveWay();
  }
  http_.Run();
  if (emergency.joinable()) emergency.join();
}

bool App::CanRecall() const {
  try {
    // A site that does not exist is never cached, so this reads the database file.
    storage_.sites.Find("none");
    return true;
  } catch (const std::exception& error) {
    spdlog::error("sites cannot be read: {}", error.what());
    return false;
  }
}

bool App::Stop(std::chrono::milliseconds patience) {
  intake_.is_stopping = true;
  events_.Stop();
  alternates_.Stop();
  if (follower_) follower_->Stop();
  http_.Stop();
  if (emergency_http_) emergency_http_->Stop();
  return !worker_ || worker_->Stop(patience);
}

}  // namespace freelsd
