// Stored maps of flights, read through one cache of tiles.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <tuple>
#include <vector>

#include "api/export/map/map.h"
#include "api/stored/map/map.h"
#include "server/maps/recent.h"
#include "server/maps/staged_picture.h"
#include "storage/storage.h"

namespace freelsd {

// A map of a flight, without its tiles.
struct FlightMap {
  FlightMapRow row;
  MapHead head;
  LocalFrame local_frame;
  // Of the flight's request.
  HazardOptions hazard_options;
  Aircraft aircraft;
  FlightMemory memory;

  // The grid of all cells of a level.
  Grid GridAt(int level) const;
};
WorldBox BoxOfGrid(const Grid& grid);
// Tiles of the map's picture at a level that lie in the box and on the map: columns in x, rows in
// y. Empty if there are none, or if the map has no picture.
cv::Rect PhotoTilesIn(const FlightMap& map, int level, const WorldBox& box);

// Stores a map with its tiles of all levels; it is not in force yet. Completes the head (number of
// levels, ranges) and writes it into the row. Returns the SHA-256 of all tiles.
std::string StageMap(Storage& storage, FlightMapRow row, MapHead head, MapRasters rasters);

// Thread-safe. The constructor's argument limits the memory of the tiles, and
// that of the pictures.
class FlightMaps {
 public:
  explicit FlightMaps(size_t max_bytes) : tiles_(max_bytes), photos_(max_bytes) {}
  FlightMaps(const FlightMaps&) = delete;
  FlightMaps& operator=(const FlightMaps&) = delete;

  // Nothing if no such map is stored, or if its head cannot be read.
  std::shared_ptr<const FlightMap> Find(const Storage& storage, const std::string& map_id);
  // All cells of `grid`, which has the lattice of the map's level. Cells are unseen where the map
  // has none. A tile that cannot be read from either copy counts as unseen, and is reported.
  MapRasters Read(
      const Storage& storage, const FlightMap& map, int level, const Grid& grid, TileLayers layers);
  // Tiles of the map's picture at a level that meet the box, in world. Tiles that cannot be read
  // are left out and reported.
  std::vector<PhotoWindow> ReadPhoto(const Storage& storage,
                                     const FlightMap& map,
                                     int level,
                                     const WorldBox& box);

 private:
  // Places of tiles over all maps.
  struct Key {
    std::string map_id;
    MapTileIndex index;

    bool operator<(const Key& other) const {
      return std::tie(map_id, index) < std::tie(other.map_id, other.index);
    }
  };
  // A tile; nullptr where the map has no seen cell.
  struct Entry {
    TileLayers layers = TileLayers::kPlanning;
    std::shared_ptr<const MapRasters> tile;
  };
  static constexpr size_t kMaxNumHeads = 256;

  std::shared_ptr<const MapRasters> TileAt(const Storage& storage,
                                           const FlightMap& map,
                                           const MapTileIndex& index,
                                           TileLayers layers);

  cv::Mat4b PhotoAt(const Storage& storage, const FlightMap& map, const MapTileIndex& index);

  // Guards heads_, tiles_ and photos_.
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<const FlightMap>> heads_;
  Recent<Key, Entry> tiles_;
  // Empty where the picture has no tile.
  Recent<Key, cv::Mat4b> photos_;
};

// Finished pictures of maps, by a text that says everything they depend on. Thread-safe.
class MapPictures {
 public:
  explicit MapPictures(size_t max_bytes) : pictures_(max_bytes) {}

  // nullptr if there is none.
  std::shared_ptr<const std::string> Find(const std::string& key);
  void Keep(const std::string& key, const std::shared_ptr<const std::string>& picture);

 private:
  // Guards pictures_.
  std::mutex mutex_;
  Recent<std::string, std::shared_ptr<const std::string>> pictures_;
};

}  // namespace freelsd
