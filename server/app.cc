#include "server/app.h"

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <set>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "api/import/import.h"
#include "server/intake/intake.h"
#include "server/jobs/jobs.h"
#include "server/routes.h"

namespace freelsd {
namespace {

struct ReadClassifier {
  Classifier classifier;
  // SHA-256 of its file.
  std::string digest;
};

ReadClassifier ReadModel(const std::filesystem::path& path, const std::string& advice) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    throw ConfigError("the grass model " + path.string() + " cannot be read; " + advice);
  }
  try {
    const std::string text(std::istreambuf_iterator<char>(file), {});
    return {Classifier::Parse(text), Sha256Hex(text)};
  } catch (const std::invalid_argument& error) {
    throw ConfigError(path.string() + " is not a grass model: " + error.what());
  }
}

Classifiers ReadModels(const Config& config) {
  ReadClassifier grass =
      ReadModel(config.model.empty() ? BesideProgram("grass_model.yml") : config.model,
                "give its path with --model");
  ReadClassifier paper = ReadModel(BesideProgram("paper_model.yml"), "install it there");
  return {std::move(grass.classifier), std::move(paper.classifier), grass.digest, paper.digest};
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

HttpServer::Handler HandlerFor(Organisations& organisations, Listener listener) {
  return [&organisations, listener](
             const httplib::Request& request, BodyReader& body, httplib::Response& response) {
    Serve(organisations, listener, request, body, response);
  };
}

}  // namespace

App::App(const Config& config)
    : config_(config),
      base_map_(config_),
      organisations_(config_, std::make_unique<Storage>(StorageOf(config_)), base_map_),
      http_(OptionsOf(config_, Listener::kMain), HandlerFor(organisations_, Listener::kMain)),
      port_(http_.Bind(config_.host, config_.port)),
      sharing_(organisations_.Default().storage, CallsOfSharing()) {
  organisations_.Default().page = ReadPageFiles(config_);
  OpenOrganisations();
  if (config_.emergency) {
    emergency_http_ = std::make_unique<HttpServer>(
        OptionsOf(config_, Listener::kEmergency), HandlerFor(organisations_, Listener::kEmergency));
    emergency_port_ = emergency_http_->Bind(config_.emergency->host, config_.emergency->port);
  }
  if (config_.role != Role::kApi) worker_.emplace(organisations_, ReadModels(config_));
  sharing_.Start();
  if (!config_.follow.empty()) BeginToFollow();
}

void App::BeginToFollow() {
  Organisation& own = *organisations_.Find(kDefaultOrganisation);
  follower_ = std::make_unique<Follower>(
      *own.storage,
      own.maps,
      own.service.copy,
      FollowOptionsOf(config_),
      [&own](const MergeResult& merged) {
        for (const SiteRow& site : merged.sites) {
          own.events.Publish("site",
                             site.flight_id,
                             nlohmann::json{{"id", site.id}, {"flight_id", site.flight_id}}.dump());
        }
        own.alternates.WakeAll();
      });
  follower_->Start();
}

// Those of the tokens and the settings.
void App::OpenOrganisations() {
  Service& service = organisations_.Default();
  organisations_.CallWithEach([this](const std::string& name, Organisation& organisation) {
    organisation.events.CallOnNews(http_.NewsCall());
    organisation.intake.streams.release(MaxNumStreams(config_) -
                                        kLimits.concurrency.max_num_streams);
    sharing_.CarryFrom(name, organisation.events);
    organisation.intake.wake_worker = [this] {
      if (worker_) worker_->Wake();
    };
    if (is_running_) organisation.alternates.Start();
  });
  if (!config_.token_file.empty()) service.tokens = TokenList::Read(config_.token_file);
  std::set<std::string> names = service.tokens.Organisations();
  for (const auto& [name, settings] : config_.organisations) names.insert(name);
  names.erase(kDefaultOrganisation);
  if (!names.empty() && service.storage.Kind() == DatabaseKind::kSqlite) {
    throw ConfigError("token file: organisation " + *names.begin() +
                      " needs --database: SQLite has one organisation");
  }
  for (const std::string& name : names) organisations_.Of(name);
  // Nobody else works for those of earlier tokens; on a shared database, a claim opens them.
  if (!service.storage.claims.IsShared()) {
    for (const std::string& name : service.storage.claims.ListOrganisations()) {
      organisations_.Of(name);
    }
  }
  if (config_.role == Role::kWorker || service.storage.Kind() == DatabaseKind::kSqlite) return;
  // Who is no longer in the settings shares no longer.
  for (const std::string& name : service.storage.claims.ListOrganisations()) {
    const auto found = config_.organisations.find(name);
    const bool is_shared = found != config_.organisations.end() && found->second.shares_sites;
    if (const Organisation* open = organisations_.Find(name)) {
      open->storage->ShareSites(is_shared);
    } else {
      service.storage.ForOrganisation(name)->ShareSites(is_shared);
    }
  }
}

SharingCalls App::CallsOfSharing() {
  SharingCalls calls;
  calls.on_work = [this] {
    if (worker_) worker_->Wake();
  };
  calls.on_event = [this](const SharedEvent& event) {
    Organisation* const organisation = organisations_.Find(event.organisation);
    if (organisation == nullptr) return;
    organisation->events.Relay(event.type, event.flight_id, event.data);
  };
  calls.on_changed_sites = [this] {
    organisations_.ForEach(
        [](const std::string&, Organisation& each) { each.alternates.WakeAll(); });
  };
  // What its threads are doing is another server's work by now, and a new start is clean.
  calls.on_lost_lease = [] {
    spdlog::critical("this server's lease was over, and another server has its flights: it ends");
    std::_Exit(kExitLostLease);
  };
  return calls;
}

void App::Run() {
  is_running_ = true;
  // Alternates are for emergencies too: before others give way to these.
  organisations_.ForEach([](const std::string&, Organisation& each) { each.alternates.Start(); });
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
    organisations_.Default().storage.sites.Find("none");
    return true;
  } catch (const std::exception& error) {
    spdlog::error("sites cannot be read: {}", error.what());
    return false;
  }
}

bool App::Stop(std::chrono::milliseconds patience) {
  organisations_.ForEach([](const std::string&, Organisation& each) {
    each.intake.is_stopping = true;
    each.events.Stop();
    each.alternates.Stop();
  });
  if (follower_) follower_->Stop();
  http_.Stop();
  if (emergency_http_) emergency_http_->Stop();
  return !worker_ || worker_->Stop(patience);
}

}  // namespace freelsd
