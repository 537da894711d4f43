#include <charconv>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/import/import.h"
#include "server/handlers/handlers.h"

namespace freelsd {
namespace {

// A day. A browser then asks again by the tag.
constexpr char kCacheControl[] = "private, max-age=86400";
// Of the tile's SHA-256, in hexadecimal digits.
constexpr size_t kTagLength = 32;

// Zoom, column or row in digits alone. Throws ApiError NoSuchTile.
int64_t TileNumber(const std::string& text) {
  int64_t number = -1;
  const char* const end = text.data() + text.size();
  const auto [parsed_to, error] = std::from_chars(text.data(), end, number);
  if (error == std::errc() && parsed_to == end && number >= 0) return number;
  throw ApiError("NoSuchTile", "a tile has three whole numbers: zoom, column and row");
}

// True if the header If-None-Match lists the tag (RFC 9110, 13.1.2).
bool Lists(const std::string& header, const std::string& tag) {
  return header == "*" || header.find(tag) != std::string::npos;
}

}  // namespace

void GetBaseMap(Service& service, const Call&, httplib::Response& response) {
  const nlohmann::json tile_json = service.base_map.TileJson();
  if (tile_json.is_null()) {
    const std::string& problem = service.base_map.problem();
    throw ApiError("NoBaseMap", problem.empty() ? "this server has no base map" : problem);
  }
  // Texts of the file need not be UTF-8.
  response.set_content(tile_json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace),
                       "application/json");
}

void GetBaseMapTile(Service& service, const Call& call, httplib::Response& response) {
  const MapTile tile = service.base_map.Tile(
      TileNumber(call.Id("z")), TileNumber(call.Id("x")), TileNumber(call.Id("y")));
  // The quotes are part of the tag, so that no other tag contains it.
  const std::string tag = '"' + Sha256Hex(tile.bytes).substr(0, kTagLength) + '"';
  response.set_header("ETag", tag);
  response.set_header("Cache-Control", kCacheControl);
  if (Lists(call.request.get_header_value("If-None-Match"), tag)) {
    response.status = 304;
    return;
  }
  response.set_content(tile.bytes, tile.media_type);
}

}  // namespace freelsd
