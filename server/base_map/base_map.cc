#include "server/base_map/base_map.h"

#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "api/api.h"
#include "api/import/import.h"
#include "server/http/http.h"

namespace freelsd {
namespace {

// What most public maps offer.
constexpr int kDefaultMaxZoom = 19;
constexpr int kMaxPortDigits = 5;

constexpr char kDigits[] = "0123456789";
constexpr char kHostCharacters[] = "abcdefghijklmnopqrstuvwxyz0123456789.-";
// What a URL may hold behind its host (RFC 3986), and braces.
constexpr char kUrlCharacters[] =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~:/?#[]@!$&'()*+,;=%{}";

[[noreturn]] void RefuseUrl(const std::string& why) { throw ConfigError("base_map_url: " + why); }

void CheckPlaceholders(const std::string& url) {
  std::string rest = url;
  for (const std::string name : {"{z}", "{x}", "{y}"}) {
    const size_t at = rest.find(name);
    if (at == std::string::npos) RefuseUrl("must contain " + name);
    rest.erase(at, name.size());
  }
  if (rest.find_first_of("{}") != std::string::npos) {
    RefuseUrl("may contain only {z}, {x} and {y}, each once");
  }
}

// The host becomes part of the page's Content-Security-Policy, so only names and IPv4 addresses.
void CheckHost(const std::string& host_and_port) {
  const size_t colon = host_and_port.find(':');
  const std::string host = host_and_port.substr(0, colon);
  const bool is_name = !host.empty() && host.front() != '-' && host.front() != '.' &&
                       host.find_first_not_of(kHostCharacters) == std::string::npos;
  if (!is_name) RefuseUrl("\"" + ShownPath(host) + "\" is not the name of one host");
  if (colon == std::string::npos) return;
  const std::string port = host_and_port.substr(colon + 1);
  const bool is_number = !port.empty() && port.size() <= kMaxPortDigits &&
                         port.find_first_not_of(kDigits) == std::string::npos;
  const int number = is_number ? std::stoi(port) : 0;
  if (number < 1 || number > 65535) RefuseUrl("\"" + ShownPath(port) + "\" is not a port");
}

void CheckSettings(const Config& config) {
  const bool has_url = !config.base_map_url.empty();
  const bool has_file = !config.base_map_file.empty();
  if (has_url && has_file) {
    throw ConfigError("base_map_url and base_map_file: only one of them may be set");
  }
  if (!has_url && !has_file && !config.base_map_attribution.empty()) {
    throw ConfigError("base_map_attribution: needs base_map_url or base_map_file");
  }
  if (!config.base_map_max_zoom) return;
  if (!has_url && !has_file) {
    throw ConfigError("base_map_max_zoom: needs base_map_url or base_map_file");
  }
  constexpr int kMaxZoom = kLimits.base_map.max_zoom;
  if (*config.base_map_max_zoom < 0 || *config.base_map_max_zoom > kMaxZoom) {
    throw ConfigError("base_map_max_zoom: must be in [0, " + std::to_string(kMaxZoom) + "]");
  }
}

// The attribution stays short enough for a line below a map.
constexpr size_t kMaxAttributionBytes = 500;

}  // namespace

std::string OriginOfTemplate(const std::string& url) {
  if (url.size() > kLimits.base_map.max_url_bytes) RefuseUrl("is too long");
  if (url.find_first_not_of(kUrlCharacters) != std::string::npos) {
    RefuseUrl("contains a character that a URL cannot contain");
  }
  const std::string lower = LowerCase(url);
  const size_t scheme_end = lower.find("://");
  const std::string scheme = lower.substr(0, scheme_end);
  if (scheme_end == std::string::npos || (scheme != "https" && scheme != "http")) {
    RefuseUrl("must begin with https:// or http://");
  }
  const size_t host_begin = scheme_end + 3;
  const size_t path_begin = lower.find_first_of("/?#", host_begin);
  if (path_begin == std::string::npos || lower[path_begin] != '/') {
    RefuseUrl("must have a path behind the host");
  }
  CheckHost(lower.substr(host_begin, path_begin - host_begin));
  CheckPlaceholders(url);
  return lower.substr(0, path_begin);
}

std::string WithoutMarkup(const std::string& text) {
  constexpr std::pair<const char*, const char*> kReferences[] = {
      {"&copy;", "\u00a9"}, {"&quot;", "\""}, {"&#39;", "'"}, {"&nbsp;", " "}, {"&amp;", "&"}};
  std::string plain;
  int depth = 0;
  for (const char c : text) {
    if (c == '<') ++depth;
    if (depth == 0 && c != '>') plain += c;
    if (c == '>' && depth > 0) --depth;
  }
  for (const auto& [reference, replacement] : kReferences) {
    const std::string name = reference;
    for (size_t at = 0; (at = plain.find(name, at)) != std::string::npos;) {
      plain.replace(at, name.size(), replacement);
      at += std::string_view(replacement).size();
    }
  }
  return plain.substr(0, kMaxAttributionBytes);
}

BaseMap::BaseMap(const Config& config) {
  CheckSettings(config);
  if (!config.base_map_url.empty()) {
    outside_origin_ = OriginOfTemplate(config.base_map_url);
    url_ = config.base_map_url;
    max_zoom_ = kDefaultMaxZoom;
  } else if (!config.base_map_file.empty()) {
    OpenFile(config);
  }
  if (!config.base_map_attribution.empty()) {
    attribution_ = WithoutMarkup(config.base_map_attribution);
  }
  if (!config.base_map_max_zoom || url_.empty()) return;
  const int max_zoom = *config.base_map_max_zoom;
  if (max_zoom < min_zoom_) {
    throw ConfigError("base_map_max_zoom: the map begins at zoom level " +
                      std::to_string(min_zoom_));
  }
  max_zoom_ = file_ ? std::min(max_zoom_, max_zoom) : max_zoom;
}

void BaseMap::OpenFile(const Config& config) {
  MbTilesOptions options;
  options.max_tile_bytes = kLimits.base_map.max_tile_bytes;
  try {
    file_ = std::make_unique<const MbTiles>(config.base_map_file, options);
  } catch (const StorageError& error) {
    problem_ =
        "base_map_file: " + config.base_map_file.string() + " cannot be used: " + error.what();
    spdlog::error("{}; the server runs without a base map", problem_);
    return;
  }
  const MbTilesInfo& info = file_->info();
  url_ = "/v1/base-map/{z}/{x}/{y}";
  name_ = WithoutMarkup(info.name);
  attribution_ = WithoutMarkup(info.attribution);
  min_zoom_ = info.min_zoom;
  max_zoom_ = info.max_zoom;
}

nlohmann::json BaseMap::TileJson() const {
  if (url_.empty()) return nullptr;
  nlohmann::json json{{"tilejson", "3.0.0"},
                      {"tiles", nlohmann::json::array({url_})},
                      {"scheme", "xyz"},
                      {"minzoom", min_zoom_},
                      {"maxzoom", max_zoom_},
                      {"attribution", attribution_}};
  if (!name_.empty()) json["name"] = name_;
  if (file_ && file_->info().bounds_deg) json["bounds"] = *file_->info().bounds_deg;
  return json;
}

MapTile BaseMap::Tile(int64_t zoom, int64_t x, int64_t y) const {
  if (!file_) {
    throw ApiError("NoBaseMap",
                   problem_.empty() ? "this server has no tiles of a base map" : problem_);
  }
  if (zoom > max_zoom_ || zoom < min_zoom_) {
    throw ApiError("NoSuchTile", "the base map has no such tile");
  }
  std::optional<MapTile> tile;
  try {
    tile = file_->Find(static_cast<int>(zoom), x, y);
  } catch (const StorageError& error) {
    // Not a fault of the server's own database, so it must not be taken for one.
    spdlog::warn("base map: {}", error.what());
    if (error.fault != StorageFault::kDamaged) {
      throw ApiError("Unavailable", "the base map's file is busy or cannot be read; try again");
    }
    throw ApiError("UnusableTile", "the tile is damaged, too large or not a picture");
  }
  if (!tile) throw ApiError("NoSuchTile", "the base map has no such tile");
  return *std::move(tile);
}

}  // namespace freelsd
