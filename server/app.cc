#include "server/app.h"

#include <fstream>
#include <iterator>

#include <spdlog/spdlog.h>

#include "server/routes.h"

namespace freelsd {
namespace {

// Seen from the program: as built, as installed, then where the sources were.
const std::vector<std::filesystem::path> kModelPlaces{"../share/freelsd/grass_model.yml",
                                                      FREELSD_SOURCE_DIR
                                                      "/engine/classification/grass_model.yml"};
const std::vector<std::filesystem::path> kPagePlaces{
    "../web/static", "../share/freelsd/web", FREELSD_PAGE_DIR};

Classifier ReadModel(const Config& config) {
  const std::filesystem::path path =
      config.model.empty() ? FirstExisting(kModelPlaces) : config.model;
  std::ifstream file(path, std::ios::binary);
  if (path.empty() || !file) {
    throw ConfigError("the grass model cannot be read; name its file with --model");
  }
  try {
    return Classifier::Parse(std::string(std::istreambuf_iterator<char>(file), {}));
  } catch (const std::invalid_argument& error) {
    throw ConfigError(path.string() + " is not a grass model: " + error.what());
  }
}

Page ReadPageFiles(const Config& config) {
  Page page = ReadPage(config.page.empty() ? FirstExisting(kPagePlaces) : config.page);
  if (!page.contains("/")) spdlog::warn("the page is not there; the service runs without it");
  return page;
}

HttpOptions OptionsOf(const Config& config) {
  HttpOptions options;
  options.allowed_hosts = config.allowed_hosts;
  options.num_threads = config.num_http_threads;
  return options;
}

}  // namespace

App::App(const Config& config)
    : config_(config),
      storage_(config_.data),
      service_(config_, storage_),
      http_(OptionsOf(config_),
            [this](const httplib::Request& request, BodyReader& body, httplib::Response& response) {
              Serve(service_, request, body, response);
            }),
      port_(http_.Bind(config_.host, config_.port)),
      worker_(service_, ReadModel(config_)) {
  service_.page = ReadPageFiles(config_);
  service_.wake_worker = [this] { worker_.Wake(); };
}

void App::Run() { http_.Run(); }

bool App::Stop(std::chrono::milliseconds patience) {
  service_.is_stopping = true;
  http_.Stop();
  return worker_.Stop(patience);
}

}  // namespace freelsd
