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
  // When the ground was last photographed, at the earliest (0: unknown) and at the latest (empty:
  // the time is exact, or there is no bound).
  int64_t seen_at_us = 0;
  std::optional<int64_t> seen_until_us = std::nullopt;
};

inline MapRow RowOf(const FlightMapRow& map) {
  return {map.id, map.flight_id, map.altitude_datum, map.seen_at_us, map.seen_until_us};
}

using Tiles = std::vector<std::pair<TileKey, std::string>>;
// SHA-256 of image files, by place.
using PhotoTiles = std::vector<std::pair<TileKey, std::string>>;

// Invariants: a map counts only once SiteStore::PutEvaluation has put it in force, in one commit
// with the sites on it. SQLite stores each map and its tiles in two databases, as sites are, and
// removes maps that are not in force when the storage is opened. PostgreSQL removes them once they
// are older than StorageOptions::unused_image_age_s, because another process may be writing them.
class MapStore {
 public:
  virtual ~MapStore() = default;
  MapStore(const MapStore&) = delete;
  MapStore& operator=(const MapStore&) = delete;

  // An id for a new map of the flight. No other map has or had it since the storage was opened.
  virtual std::string NewId(const std::string& flight_id) = 0;
  // Stores a map that is not in force yet, and its tiles. The files of its photo tiles may be
  // stored later (ImageStore), when these rows keep them.
  virtual void Stage(const FlightMapRow& map,
                     const Tiles& tiles,
                     const PhotoTiles& photo_tiles) = 0;
  // Adds tiles to a map that is not in force yet.
  virtual void StageTiles(const std::string& map_id,
                          const Tiles& tiles,
                          const PhotoTiles& photo_tiles) = 0;
  // Removes a map that is not in force.
  virtual void Discard(const std::string& map_id) = 0;

  // Maps in force. Newest first.
  virtual std::vector<FlightMapRow> ListOf(const std::string& flight_id) const = 0;
  // Also a map that is not in force yet.
  virtual std::optional<FlightMapRow> Find(const std::string& map_id) const = 0;
  virtual std::optional<std::string> ReadTile(const std::string& map_id,
                                              const TileKey& key) const = 0;
  // In order.
  virtual std::vector<TileKey> ListTiles(const std::string& map_id) const = 0;
  // ReadTile from the second copy, if the database has one.
  virtual std::optional<std::string> ReadTileCopy(const std::string& map_id,
                                                  const TileKey& key) const = 0;
  virtual std::optional<std::string> FindPhotoTile(const std::string& map_id,
                                                   const TileKey& key) const = 0;
  // All of one level.
  virtual PhotoTiles ListPhotoTiles(const std::string& map_id, int64_t level) const = 0;
  // Number of photo tiles at each level from 0 on.
  virtual std::vector<int64_t> CountPhotoTiles(const std::string& map_id) const = 0;
  // Removes the photo tiles of the flight's maps, and their files that nothing else needs.
  virtual void RemovePhotoTiles(const std::string& flight_id) = 0;
  // Flights whose maps have photo tiles, the least recently updated first.
  virtual std::vector<std::string> ListFlightsWithPhotoTiles() const = 0;

 protected:
  MapStore() = default;
};

}  // namespace freelsd
