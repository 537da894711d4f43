// SQL for maps of flights and their tiles, on a connection to the main database or to the second
// copy.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "storage/box_cache.h"
#include "storage/map_store.h"
#include "storage/sqlite/sqlite.h"

namespace freelsd {

// All writes are within the caller's transaction.
void PutMapRow(const Connection& writer, const FlightMapRow& map, bool is_in_force);
void PutTileRows(const Connection& writer, const std::string& map_id, const Tiles& tiles);
// Only in the main database: the images are no part of the second copy.
void PutPhotoTileRows(const Connection& writer,
                      const std::string& map_id,
                      const PhotoTiles& photo_tiles);
void PutMapInForce(const Connection& writer, const std::string& map_id);
// With its tiles.
void DeleteMapRow(const Connection& writer, const std::string& map_id);
void DeleteUnfinishedMaps(const Connection& writer);
void DeletePhotoTileRowsOf(const Connection& writer, const std::string& flight_id);

// Maps in force, newest first. Throws StorageError kDamaged if a checksum is wrong.
std::vector<FlightMapRow> ListMapRowsOf(const Connection& connection, const std::string& flight_id);
// Also a map that is not in force.
std::optional<FlightMapRow> FindMapRow(const Connection& connection, const std::string& map_id);
std::optional<std::string> ReadTileRow(const Connection& connection,
                                       const std::string& map_id,
                                       const TileKey& key);
// The box must not cross the antimeridian.
BoxCache<MapRow>::Rows ListMapRows(const Connection& connection, const BoundingBox& box);
// Image files of the photo tiles of these maps that neither a frame nor another map needs.
std::vector<std::string> OwnPhotoFiles(const Connection& connection,
                                       const std::vector<std::string>& map_ids);
// Whether a frame or a photo tile needs the image file. Only for the main database.
bool IsImageNeeded(const Connection& connection, const std::string& sha256);
// Reads all rows once. Throws StorageError kDamaged if a checksum is wrong.
void CheckMapRows(const Connection& connection);

// By which two copies of a map are compared: a stored map never changes.
struct MapContent {
  int64_t checksum = 0;
  bool is_in_force = false;
  int64_t num_tiles = 0;
};
// Nothing if there is no such map.
std::optional<MapContent> MapContentOf(const Connection& connection, const std::string& map_id);

// Ids of maps in force with their checksums, by which two databases are compared.
using MapStamps = std::map<std::string, int64_t>;
MapStamps MapStampsOf(const Connection& connection);

}  // namespace freelsd
