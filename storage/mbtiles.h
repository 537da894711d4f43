// Reads raster map tiles from an MBTiles 1.3 file, which somebody else made and which may be
// damaged or hostile. Never writes, locks or creates a file.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

namespace freelsd {

struct MbTilesOptions {
  // A larger tile is refused.
  size_t max_tile_bytes = size_t{2} << 20;
  // Longest search for a tile, and longest wait for the searches of other threads. Only a file
  // without an index, or a hostile view, needs so long.
  std::chrono::milliseconds max_search{1000};
  // The same when the file is opened.
  std::chrono::milliseconds max_opening{10000};
};

// What the file says of itself. Texts are as in the file: they may hold markup, and need not be
// UTF-8.
struct MbTilesInfo {
  std::string name;
  std::string attribution;
  int min_zoom = 0;
  int max_zoom = 0;
  // West, south, east, north in degrees; nothing if the file has none or they are no box.
  std::optional<std::array<double, 4>> bounds_deg;
};

struct MapTile {
  std::string bytes;
  // image/png, image/jpeg or image/webp, by the first bytes of the tile.
  std::string media_type;
};

// Thread-safe. One thread searches at a time. Throws StorageError whose text is a sentence without
// the file's path. Its fault says nothing about the database of Storage.
class MbTiles {
 public:
  // Opens the file as immutable: a program that changes it in place must not run at the same time.
  // Refuses what has no tiles, and tiles that are no pictures, e.g. vector tiles.
  explicit MbTiles(const std::filesystem::path& file, const MbTilesOptions& options = {});
  ~MbTiles();
  MbTiles(const MbTiles&) = delete;
  MbTiles& operator=(const MbTiles&) = delete;

  const MbTilesInfo& info() const;
  // The tile in column x, counted from the antimeridian to the east, and row y, counted from the
  // north to the south (XYZ; the file counts rows from the south). Nothing if there is no such
  // tile. Throws if the tile is too large or no picture, or if the file cannot be read there.
  std::optional<MapTile> Find(int zoom, int64_t x, int64_t y) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace freelsd
