// The maps of a flight: pictures in tiles, files, and any place on them.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/export/map/map.h"
#include "api/import/import.h"
#include "server/handlers/flight_picture.h"
#include "server/handlers/handlers.h"
#include "server/handlers/lookups.h"

namespace freelsd {
namespace {

// Of a tile's number in a path.
int TileNumber(const Call& call, const std::string& name) {
  const std::string& text = call.Id(name);
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error == std::errc() && end == text.data() + text.size() && number >= 0) return number;
  throw ApiError("InvalidValue",
                 name + ": must be a whole number, not negative",
                 {{name, "must be a whole number, not negative"}});
}

XyzTile TileOf(const Call& call) {
  const XyzTile tile{TileNumber(call, "z"), TileNumber(call, "x"), TileNumber(call, "y")};
  try {
    tile.Check();
  } catch (const std::invalid_argument& error) {
    throw ApiError("InvalidValue", error.what(), {{"z", error.what()}});
  }
  return tile;
}

void CheckLayer(const std::string& layer) {
  const std::vector<std::string> names = MapLayerNames();
  if (std::find(names.begin(), names.end(), layer) != names.end()) return;
  throw ApiError("NoSuchLayer", "there is no such layer");
}

// Answers 304 if the client has what the tag names.
bool AnswerUnchanged(const std::string& version, const Call& call, httplib::Response& response) {
  const std::string tag = "\"" + version + "\"";
  response.set_header("ETag", tag);
  response.set_header("Cache-Control", "private, no-cache");
  const std::string known = call.request.get_header_value("If-None-Match");
  if (known != "*" && known.find(tag) == std::string::npos) return false;
  response.status = 304;
  return true;
}

// Absolute, as the client reached the server.
std::string BaseUrl(const Call& call) {
  const bool is_https = call.request.get_header_value("X-Forwarded-Proto") == "https";
  return (is_https ? "https://" : "http://") + call.request.get_header_value("Host") +
         "/v1/flights/" + call.Id("flight") + "/map";
}

void AnswerTile(Service& service,
                const Call& call,
                const std::string& layer,
                const char* content_type,
                httplib::Response& response) {
  const XyzTile tile = TileOf(call);
  const FlightPicture maps(service, call.Id("flight"));
  const std::string key = call.request.path + " " + maps.version();
  std::shared_ptr<const std::string> picture = service.pictures.Find(key);
  if (!picture) {
    picture = std::make_shared<const std::string>(maps.Tile(layer, tile, content_type));
    service.pictures.Keep(key, picture);
  }
  // Where a map grows, most tiles stay the same.
  if (AnswerUnchanged(Sha256Hex(*picture), call, response)) return;
  response.set_content(*picture, content_type);
}

}  // namespace

void GetFlightMap(Service& service, const Call& call, httplib::Response& response) {
  const FlightPicture maps(service, call.Id("flight"));
  response.set_content(maps.Json(BaseUrl(call)).dump(), "application/json");
}

void GetMapTilePng(Service& service, const Call& call, httplib::Response& response) {
  CheckLayer(call.Id("layer"));
  AnswerTile(service, call, call.Id("layer"), "image/png", response);
}

void GetMapTileJpeg(Service& service, const Call& call, httplib::Response& response) {
  if (call.Id("layer") != "photo") {
    throw ApiError("NoSuchLayer", "only the layer photo has tiles in JPEG");
  }
  AnswerTile(service, call, "photo", "image/jpeg", response);
}

void GetMapGeoTiff(Service& service, const Call& call, httplib::Response& response) {
  const std::string& layer = call.Id("layer");
  CheckLayer(layer);
  const StopIfUnwanted stop_if_unwanted = WantedBy(service, call);
  const FlightPicture maps(service, call.Id("flight"), stop_if_unwanted);
  maps.RequireLayer(layer);
  if (AnswerUnchanged(maps.version(), call, response)) return;
  const LongPlace place(service.long_queues.files, stop_if_unwanted);
  const SpooledFile file(service.storage.SpoolFolder());
  maps.WriteGeoTiff(layer, file.path());
  AnswerFile(response, "image/tiff", file.path());
}

void GetMapKmz(Service& service, const Call& call, httplib::Response& response) {
  const std::string& layer = call.Id("layer");
  CheckLayer(layer);
  const StopIfUnwanted stop_if_unwanted = WantedBy(service, call);
  const FlightPicture maps(service, call.Id("flight"), stop_if_unwanted);
  maps.RequireLayer(layer);
  if (AnswerUnchanged(maps.version(), call, response)) return;
  const LongPlace place(service.long_queues.files, stop_if_unwanted);
  response.set_content(maps.Kmz(layer), "application/vnd.google-earth.kmz");
}

void GetMapLegend(Service& service, const Call& call, httplib::Response& response) {
  CheckLayer(call.Id("layer"));
  const FlightPicture maps(service, call.Id("flight"));
  const std::string legend = maps.Legend(call.Id("layer"));
  if (AnswerUnchanged(maps.version(), call, response)) return;
  response.set_content(legend, "image/png");
}

}  // namespace freelsd
