#include <set>

#include "storage/postgres/area_rows.h"
#include "storage/postgres/images.h"
#include "storage/postgres/state.h"
#include "storage/postgres/stores.h"

namespace freelsd {
namespace {

constexpr char kSelectMaps[] =
    "SELECT id, flight_id, head_json, altitude_datum, west_deg, south_deg, east_deg, north_deg, "
    "updated_at_us, seen_at_us, seen_until_us FROM maps ";

FlightMapRow MapRowOf(const PostgresRow& row) {
  FlightMapRow map;
  map.id = row.Text(0);
  map.flight_id = row.Text(1);
  map.head_json = row.Text(2);
  map.altitude_datum = row.Text(3);
  map.box = {row.Real(4), row.Real(5), row.Real(6), row.Real(7)};
  map.updated_at_us = row.Int(8);
  map.seen_at_us = row.Int(9);
  map.seen_until_us = row.OptionalInt(10);
  return map;
}

// The number is the one at the end of '<flight>/<number>'.
void InsertStagedMap(PostgresConnection& writer, const FlightMapRow& map) {
  writer.Run(
      "INSERT INTO maps (id, flight_id, number, head_json, altitude_datum, west_deg, south_deg, "
      "east_deg, north_deg, updated_at_us, seen_at_us, is_in_force, seen_until_us) "
      "VALUES ($1, $2, coalesce(substring($1 from '/([0-9]+)$')::bigint, 0), $3, $4, $5, $6, $7, "
      "$8, $9, $10, false, nullif($11, 0))",
      map.id,
      map.flight_id,
      map.head_json,
      map.altitude_datum,
      map.box.west_deg,
      map.box.south_deg,
      map.box.east_deg,
      map.box.north_deg,
      map.updated_at_us,
      map.seen_at_us,
      map.seen_until_us.value_or(0));
  PutMapArea(writer, map.id, map.box);
}

// Rows of images whose files come later, in one order for all who lock several.
void PutImagesToCome(PostgresConnection& writer, const PhotoTiles& photo_tiles) {
  std::set<std::string> images;
  for (const auto& [key, sha256] : photo_tiles) images.insert(sha256);
  for (const std::string& sha256 : images) {
    // Locks the row, also where it is already there: nobody removes it before the commit.
    writer.Run(
        "INSERT INTO images (sha256, num_bytes) VALUES ($1, 0) "
        "ON CONFLICT (sha256) DO UPDATE SET num_bytes = images.num_bytes",
        sha256);
  }
}

void PutTiles(PostgresConnection& writer,
              const std::string& map_id,
              const Tiles& tiles,
              const PhotoTiles& photo_tiles) {
  for (const auto& [key, tile] : tiles) {
    writer.Run(
        "INSERT INTO map_tiles (map_id, level, row, col, tile) VALUES ($1, $2, $3, $4, $5) "
        "ON CONFLICT (map_id, level, row, col) DO UPDATE SET tile = $5",
        map_id,
        key.level,
        key.row,
        key.col,
        Bytes{tile});
  }
  PutImagesToCome(writer, photo_tiles);
  for (const auto& [key, sha256] : photo_tiles) {
    writer.Run(
        "INSERT INTO photo_tiles (map_id, level, row, col, sha256) VALUES ($1, $2, $3, $4, $5) "
        "ON CONFLICT (map_id, level, row, col) DO UPDATE SET sha256 = $5",
        map_id,
        key.level,
        key.row,
        key.col,
        sha256);
  }
}

}  // namespace

std::string PostgresMapStore::NewId(const std::string& flight_id) {
  PostgresWrite writer(state_);
  const PostgresRows rows = writer->Run(
      "INSERT INTO map_numbers (flight_id, last) "
      "VALUES ($1, 1 + (SELECT coalesce(max(number), 0) FROM maps WHERE flight_id = $1)) "
      "ON CONFLICT (flight_id) DO UPDATE SET last = 1 + greatest(map_numbers.last, "
      "(SELECT coalesce(max(number), 0) FROM maps WHERE flight_id = $1)) RETURNING last",
      flight_id);
  std::string id = flight_id + "/" + std::to_string(rows[0].Int(0));
  writer.Commit();
  return id;
}

void PostgresMapStore::Stage(const FlightMapRow& map,
                             const Tiles& tiles,
                             const PhotoTiles& photo_tiles) {
  PostgresWrite writer(state_);
  InsertStagedMap(*writer, map);
  PutTiles(*writer, map.id, tiles, photo_tiles);
  writer.Commit();
}

void PostgresMapStore::StageTiles(const std::string& map_id,
                                  const Tiles& tiles,
                                  const PhotoTiles& photo_tiles) {
  PostgresWrite writer(state_);
  PutTiles(*writer, map_id, tiles, photo_tiles);
  writer.Commit();
}

void PostgresMapStore::Discard(const std::string& map_id) {
  std::vector<std::string> images;
  {
    PostgresWrite writer(state_);
    images =
        writer->Run("SELECT DISTINCT sha256 FROM photo_tiles WHERE map_id = $1", map_id).Texts();
    writer->Run("DELETE FROM maps WHERE id = $1 AND NOT is_in_force", map_id);
    writer.Commit();
  }
  RemoveUnusedImages(state_, images);
}

std::vector<FlightMapRow> PostgresMapStore::ListOf(const std::string& flight_id) const {
  return state_.Read([&](PostgresConnection& connection) {
    return connection
        .Run(std::string(kSelectMaps) + "WHERE flight_id = $1 AND is_in_force ORDER BY number DESC",
             flight_id)
        .Each(MapRowOf);
  });
}

std::optional<FlightMapRow> PostgresMapStore::Find(const std::string& map_id) const {
  return state_.Read([&](PostgresConnection& connection) -> std::optional<FlightMapRow> {
    const PostgresRows rows = connection.Run(std::string(kSelectMaps) + "WHERE id = $1", map_id);
    if (rows.empty()) return std::nullopt;
    return MapRowOf(rows[0]);
  });
}

std::optional<std::string> PostgresMapStore::ReadTile(const std::string& map_id,
                                                      const TileKey& key) const {
  return state_.Read([&](PostgresConnection& connection) -> std::optional<std::string> {
    const PostgresRows rows = connection.Run(
        "SELECT tile FROM map_tiles WHERE map_id = $1 AND level = $2 AND row = $3 AND col = $4",
        map_id,
        key.level,
        key.row,
        key.col);
    if (rows.empty()) return std::nullopt;
    return rows[0].Text(0);
  });
}

std::vector<TileKey> PostgresMapStore::ListTiles(const std::string& map_id) const {
  return state_.Read([&](PostgresConnection& connection) {
    return connection
        .Run("SELECT level, row, col FROM map_tiles WHERE map_id = $1 ORDER BY level, row, col",
             map_id)
        .Each([](const PostgresRow& row) {
          return TileKey{row.Int(0), row.Int(1), row.Int(2)};
        });
  });
}

std::optional<std::string> PostgresMapStore::ReadTileCopy(const std::string& map_id,
                                                          const TileKey& key) const {
  return ReadTile(map_id, key);
}

std::optional<std::string> PostgresMapStore::FindPhotoTile(const std::string& map_id,
                                                           const TileKey& key) const {
  return state_.Read([&](PostgresConnection& connection) -> std::optional<std::string> {
    const PostgresRows rows = connection.Run(
        "SELECT sha256 FROM photo_tiles "
        "WHERE map_id = $1 AND level = $2 AND row = $3 AND col = $4",
        map_id,
        key.level,
        key.row,
        key.col);
    if (rows.empty()) return std::nullopt;
    return rows[0].Text(0);
  });
}

PhotoTiles PostgresMapStore::ListPhotoTiles(const std::string& map_id, int64_t level) const {
  return state_.Read([&](PostgresConnection& connection) {
    return connection
        .Run(
            "SELECT row, col, sha256 FROM photo_tiles WHERE map_id = $1 AND level = $2 "
            "ORDER BY row, col",
            map_id,
            level)
        .Each([&](const PostgresRow& row) {
          return std::pair(TileKey{level, row.Int(0), row.Int(1)}, row.Text(2));
        });
  });
}

std::vector<int64_t> PostgresMapStore::CountPhotoTiles(const std::string& map_id) const {
  return state_.Read([&](PostgresConnection& connection) {
    return connection
        .Run("SELECT count(*) FROM photo_tiles WHERE map_id = $1 GROUP BY level ORDER BY level",
             map_id)
        .Each([](const PostgresRow& row) { return row.Int(0); });
  });
}

void PostgresMapStore::RemovePhotoTiles(const std::string& flight_id) {
  std::vector<std::string> images;
  {
    PostgresWrite writer(state_);
    StepSites(*writer);
    images = writer
                 ->Run(
                     "WITH removed AS (DELETE FROM photo_tiles WHERE map_id IN "
                     "(SELECT id FROM maps WHERE flight_id = $1) RETURNING sha256) "
                     "SELECT DISTINCT sha256 FROM removed",
                     flight_id)
                 .Texts();
    writer.Commit();
  }
  RemoveUnusedImages(state_, images);
}

std::vector<std::string> PostgresMapStore::ListFlightsWithPhotoTiles() const {
  return state_.Read([](PostgresConnection& connection) {
    return connection
        .Run(
            "SELECT flight_id FROM maps WHERE is_in_force AND EXISTS "
            "(SELECT 1 FROM photo_tiles WHERE map_id = maps.id) "
            "GROUP BY flight_id ORDER BY max(updated_at_us), flight_id")
        .Texts();
  });
}

}  // namespace freelsd
