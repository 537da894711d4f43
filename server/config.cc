#include "server/config.h"

#include <algorithm>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string_view>
#include <type_traits>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "api/api.h"

namespace freelsd {
namespace {

bool IsLoopback(const std::string& host) {
  const bool is_ipv4 = host.find_first_not_of("0123456789.") == std::string::npos;
  return host == "localhost" || host == "::1" || (is_ipv4 && host.starts_with("127."));
}

// Nobody between the two reads along.
bool IsSecret(const std::string& url) {
  constexpr std::string_view kPlain = "http://";
  if (!url.starts_with(kPlain)) return true;
  const std::string authority = url.substr(kPlain.size(), url.find('/', kPlain.size()));
  const bool is_ipv6 = authority.starts_with('[');
  return IsLoopback(is_ipv6 ? authority.substr(1, authority.find(']') - 1)
                            : authority.substr(0, authority.find(':')));
}

int ParsePort(const std::string& text) {
  const bool is_number = !text.empty() && text.size() <= 5 &&
                         text.find_first_not_of("0123456789") == std::string::npos;
  const int port = is_number ? std::stoi(text) : -1;
  if (port < 0 || port > 65535) throw ConfigError("listen: \"" + text + "\" is not a port");
  return port;
}

template <typename T>
void Take(nlohmann::json& object, const char* key, T& value) {
  const auto found = object.find(key);
  if (found == object.end()) return;
  constexpr bool kIsCount = std::is_unsigned_v<T> && !std::is_same_v<T, bool>;
  if (kIsCount && !found->is_number_unsigned()) {
    throw ConfigError(std::string("config file: ") + key + " must be a whole number, 0 or more");
  }
  try {
    found->get_to(value);
  } catch (const nlohmann::json::exception&) {
    throw ConfigError(std::string("config file: ") + key + " has the wrong type");
  }
  object.erase(found);
}

void TakePath(nlohmann::json& object, const char* key, std::filesystem::path& value) {
  std::string text = value.string();
  Take(object, key, text);
  value = text;
}

nlohmann::json ReadFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw ConfigError("config file: cannot read " + path);
  try {
    nlohmann::json object = ParseJson(std::string(std::istreambuf_iterator<char>(file), {}));
    if (!object.is_object()) throw ConfigError("config file: must be a JSON object");
    return object;
  } catch (const ApiError& error) {
    throw ConfigError(std::string("config file: ") + error.what());
  }
}

void SetListen(const std::string& listen, Config& config) {
  const Address address = ParseAddress(listen);
  config.host = address.host;
  config.port = address.port;
}

void TakeBaseMap(nlohmann::json& object, Config& config) {
  Take(object, "base_map_url", config.base_map_url);
  TakePath(object, "base_map_file", config.base_map_file);
  Take(object, "base_map_attribution", config.base_map_attribution);
  if (!object.contains("base_map_max_zoom")) return;
  config.base_map_max_zoom = 0;
  Take(object, "base_map_max_zoom", *config.base_map_max_zoom);
}

void SetRole(const std::string& role, Config& config) {
  if (role == "api") {
    config.role = Role::kApi;
  } else if (role == "worker") {
    config.role = Role::kWorker;
  } else if (role == "all") {
    config.role = Role::kAll;
  } else {
    throw ConfigError("role: \"" + role + "\" is none; roles are api, worker and all");
  }
}

void ReadConfigFile(const std::string& path, Config& config) {
  nlohmann::json object = ReadFile(path);
  TakePath(object, "data", config.data);
  Take(object, "database", config.database);
  TakePath(object, "images", config.images);
  std::string role;
  Take(object, "role", role);
  if (!role.empty()) SetRole(role, config);
  TakePath(object, "model", config.model);
  TakePath(object, "page", config.page);
  std::string listen;
  Take(object, "listen", listen);
  if (!listen.empty()) SetListen(listen, config);
  std::string emergency_listen;
  Take(object, "emergency_listen", emergency_listen);
  if (!emergency_listen.empty()) config.emergency = ParseAddress(emergency_listen);
  TakePath(object, "token_file", config.token_file);
  Take(object, "allowed_hosts", config.allowed_hosts);
  Take(object, "num_http_threads", config.num_http_threads);
  Take(object, "max_num_queued_frames", config.max_num_queued_frames);
  Take(object, "max_num_open_flights", config.max_num_open_flights);
  Take(object, "num_alternates", config.num_alternates);
  Take(object, "recall_cache_mib", config.recall_cache_mib);
  Take(object, "max_batch_bytes", config.max_batch_bytes);
  Take(object, "max_image_age_days", config.max_image_age_days);
  Take(object, "max_stored_image_bytes", config.max_stored_image_bytes);
  Take(object, "telemetry_wait_s", config.telemetry_wait_s);
  Take(object, "max_telemetry_gap_s", config.max_telemetry_gap_s);
  Take(object, "max_telemetry_extrapolation_s", config.max_telemetry_extrapolation_s);
  TakeBaseMap(object, config);
  Take(object, "follow", config.follow);
  Take(object, "area", config.area);
  TakePath(object, "follow_token_file", config.follow_token_file);
  if (!object.empty()) throw ConfigError("config file: unknown key " + object.begin().key());
}

// A listener that other machines can reach must require tokens.
void CheckAddress(const std::string& host, const Config& config) {
  if (IsLoopback(host) || !config.token_file.empty()) return;
  throw ConfigError("listen: " + host +
                    " is not a loopback address; other addresses need a --token-file");
}

void CheckDatabase(const Config& config) {
  if (config.data.empty()) {
    throw ConfigError("--data is required: the folder for the database and the images");
  }
  if (config.database.empty()) {
    if (config.role)
      throw ConfigError("--role needs --database: roles share a PostgreSQL database");
    if (config.images.empty()) return;
    throw ConfigError("--images needs --database: with SQLite, images are in the folder of --data");
  }
  if (!config.database.starts_with("postgresql://") &&
      !config.database.starts_with("postgres://")) {
    throw ConfigError("--database: must be a URI postgresql://[USER@]HOST[:PORT]/NAME");
  }
  if (config.images.empty()) {
    throw ConfigError("--database needs --images: the folder that all servers on it share");
  }
}

void CheckFollow(const Config& config) {
  if (config.follow.empty()) {
    if (config.area.empty() && config.follow_token_file.empty()) return;
    throw ConfigError("--area and --follow-token-file need --follow");
  }
  if (!config.follow.starts_with("https://") && !config.follow.starts_with("http://")) {
    throw ConfigError("--follow: must be https://HOST[:PORT] or http://HOST[:PORT]");
  }
  if (!config.follow_token_file.empty() && !IsSecret(config.follow)) {
    throw ConfigError("--follow: a token goes over https:// only, or to this machine");
  }
  if (config.area.empty()) throw ConfigError("--follow needs --area WEST,SOUTH,EAST,NORTH");
  if (!config.database.empty()) {
    throw ConfigError("--follow: only a server on SQLite follows another one");
  }
}

void Check(const Config& config) {
  CheckAddress(config.host, config);
  if (config.emergency) CheckAddress(config.emergency->host, config);
  CheckDatabase(config);
  CheckFollow(config);
  if (config.num_http_threads < 2 || config.num_http_threads > 512) {
    throw ConfigError("num_http_threads: must be in [2, 512]");
  }
  for (const double seconds : {config.telemetry_wait_s,
                               config.max_telemetry_gap_s,
                               config.max_telemetry_extrapolation_s}) {
    if (!(seconds >= 0.0 && seconds <= 60.0)) {
      throw ConfigError("telemetry times: must be in [0, 60] s");
    }
  }
  if (!(config.max_image_age_days >= 0.0)) throw ConfigError("max_image_age_days: must be >= 0");
  if (config.max_num_queued_frames < 1) throw ConfigError("max_num_queued_frames: must be >= 1");
  if (config.max_num_open_flights < 1) throw ConfigError("max_num_open_flights: must be >= 1");
  constexpr int kMinCacheMib = 96, kMaxCacheMib = 1 << 20;
  if (config.recall_cache_mib < kMinCacheMib || config.recall_cache_mib > kMaxCacheMib) {
    throw ConfigError("recall_cache_mib: must be in [96, 1048576]");
  }
  constexpr int kMaxNumAlternates = static_cast<int>(kLimits.answer.max_num_alternates);
  if (config.num_alternates < 1 || config.num_alternates > kMaxNumAlternates) {
    throw ConfigError("num_alternates: must be in [1, " + std::to_string(kMaxNumAlternates) + "]");
  }
}

}  // namespace

Address ParseAddress(const std::string& listen) {
  const size_t colon = listen.rfind(':');
  if (colon == std::string::npos) throw ConfigError("listen: must be ADDRESS:PORT");
  std::string host = listen.substr(0, colon);
  if (host.starts_with("[") && host.ends_with("]")) host = host.substr(1, host.size() - 2);
  return {host, ParsePort(listen.substr(colon + 1))};
}

std::optional<Config> ReadConfig(int argc, const char* const* argv) {
  CLI::App app("HTTP/JSON service that finds landing sites for small planes.", "freelsd-server");
  std::string data, database, images, role, listen, emergency_listen, config_file, model, page,
      token_file, follow, area, follow_token_file;
  app.add_option("--data", data, "Folder for the database and the images");
  app.add_option("--database", database, "PostgreSQL URI without a password, default: SQLite");
  app.add_option("--images", images, "Folder of the images beside a PostgreSQL database");
  app.add_option(
      "--role", role, "api, worker or all: what this server does among several on the database");
  app.add_option("--listen", listen, "ADDRESS:PORT, default 127.0.0.1:8080");
  app.add_option("--emergency-listen",
                 emergency_listen,
                 "ADDRESS:PORT of a second listener, for /v1/emergency, with its own threads");
  app.add_option("--token-file", token_file, "JSON list of token hashes and their scopes");
  app.add_option("--follow", follow, "https://HOST of the server to keep a copy of and to send to");
  app.add_option("--area", area, "WEST,SOUTH,EAST,NORTH in degrees, of the copy");
  app.add_option("--follow-token-file", follow_token_file, "File with the token for that server");
  app.add_option("--config", config_file, "JSON file with these and further settings");
  app.add_option(
      "--model",
      model,
      "Network of ground kinds (.onnx, its .json beside it), default: beside the program");
  app.add_option("--page", page, "Folder of the page, default: beside the program");
  app.set_version_flag("--version", "freelsd-server " FREELSD_VERSION);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    app.exit(success);
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    throw ConfigError(error.what());
  }
  Config config;
  if (!config_file.empty()) ReadConfigFile(config_file, config);
  if (!data.empty()) config.data = data;
  if (!database.empty()) config.database = database;
  if (!images.empty()) config.images = images;
  if (!role.empty()) SetRole(role, config);
  if (!listen.empty()) SetListen(listen, config);
  if (!emergency_listen.empty()) config.emergency = ParseAddress(emergency_listen);
  if (!token_file.empty()) config.token_file = token_file;
  if (!model.empty()) config.model = model;
  if (!page.empty()) config.page = page;
  if (!follow.empty()) config.follow = follow;
  if (!area.empty()) config.area = area;
  if (!follow_token_file.empty()) config.follow_token_file = follow_token_file;
  Check(config);
  return config;
}

}  // namespace freelsd
