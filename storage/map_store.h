// Maps of flights, in tiles, and the pictures of the ground that belong to them. They stay when the
// flight is deleted.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "storage/site_store.h"

namespace freelsd {

// Place of a tile in its map. Storage does not interpret it.
struct TileKey {
  int64_t level = 0;
  int64_t row = 0;
  int64_t col = 0;

  bool operator==(const TileKey&) const = default;
  bool operator<(const TileKey& other) const {
    return std::tie(level, row, col) < std::tie(other.level, other.row, other.col);
  }
};

// One map of a flight. A stored map never changes: a new evaluation stores a new map.
struct FlightMapRow {
  // '<flight>/<number>'.
  std::string id;
  std::string flight_id;
  // Grid, frames, deviations: storage does not parse it.
  std::string head_json;
  std::string altitude_datum = "unknown";
  BoundingBox box{};
  int64_t updated_at_us = 0;
  // When the ground was last photographed.
  int64_t seen_at_us = 0;
};

using Tiles = std::vector<std::pair<TileKey, std::string>>;
// SHA-256 of image files, by place.
using PhotoTiles = std::vector<std::pair<TileKey, std::string>>;

// Invariants: each map and its tiles are stored in two databases, as sites are. A map counts only
// once SiteStore::PutEvaluation has put it in force, in one commit with the sites on it. Maps that
// are not in force are removed when the storage is opened.
class MapStore {
 public:
  explicit MapStore(StorageState& state) : state_(state) {}
  MapStore(const MapStore&) = delete;
  MapStore& operator=(const MapStore&) = delete;

  // An id for a new map of the flight. No other map has or had it since the storage was opened.
  std::string NewId(const std::string& flight_id);
  // Stores a map that is not in force yet, and its tiles. Files of photo tiles are stored before
  // (ImageStore).
  void Stage(const FlightMapRow& map, const Tiles& tiles, const PhotoTiles& photo_tiles);
  // Adds tiles to a map that is not in force yet.
  void StageTiles(const std::string& map_id, const Tiles& tiles, const PhotoTiles& photo_tiles);
  // Removes a map that is not in force.
  void Discard(const std::string& map_id);

  // Maps in force. Newest first.
  std::vector<FlightMapRow> ListOf(const std::string& flight_id) const;
  // Also a map that is not in force yet.
  std::optional<FlightMapRow> Find(const std::string& map_id) const;
  std::optional<std::string> ReadTile(const std::string& map_id, const TileKey& key) const;
  // The same from the second copy.
  std::optional<std::string> ReadTileCopy(const std::string& map_id, const TileKey& key) const;
  std::optional<std::string> FindPhotoTile(const std::string& map_id, const TileKey& key) const;
  // All of one level.
  PhotoTiles ListPhotoTiles(const std::string& map_id, int64_t level) const;
  // Number of photo tiles at each level from 0 on.
  std::vector<int64_t> CountPhotoTiles(const std::string& map_id) const;
  // Removes the photo tiles of the flight's maps, and their files that nothing else needs.
  void RemovePhotoTiles(const std::string& flight_id);
  // Flights whose maps have photo tiles, the least recently updated first.
  std::vector<std::string> ListFlightsWithPhotoTiles() const;

 private:
  StorageState& state_;
};

}  // namespace freelsd
