// The map below the page's overlays, as the operator configured it: none, tiles from elsewhere, or
// an MBTiles file. It is a picture only; nothing is computed from it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "server/config.h"
#include "storage/storage.h"

namespace freelsd {

// Thread-safe.
class BaseMap {
 public:
  // Opens the file if one is configured; without a usable one there is no base map. Throws
  // ConfigError with a sentence that names the setting.
  explicit BaseMap(const Config& config);

  // What the page's browser may load pictures from, e.g. "https://tiles.example.org". Empty if the
  // map comes from this server or there is none.
  const std::string& outside_origin() const { return outside_origin_; }
  // Why the configured file is not used; empty if it is.
  const std::string& problem() const { return problem_; }
  // TileJSON 3.0; null if there is no base map. The attribution is plain text.
  nlohmann::json TileJson() const;
  // A tile of the file, XYZ. Throws ApiError NoBaseMap if no file is configured, NoSuchTile,
  // UnusableTile, or Unavailable if the search takes too long.
  MapTile Tile(int64_t zoom, int64_t x, int64_t y) const;

 private:
  void OpenFile(const Config& config);

  std::string problem_;
  std::string url_;
  std::string outside_origin_;
  std::string name_;
  std::string attribution_;
  int min_zoom_ = 0;
  int max_zoom_ = 0;
  std::unique_ptr<const MbTiles> file_;
};

// The origin of a URL template, e.g. "https://tiles.example.org:8443" of
// "https://tiles.example.org:8443/{z}/{x}/{y}.png". Throws ConfigError if it is no template of
// exactly one origin.
std::string OriginOfTemplate(const std::string& url);
// The text without tags, and with the usual character references replaced.
std::string WithoutMarkup(const std::string& text);

}  // namespace freelsd
