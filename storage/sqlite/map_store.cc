#include <algorithm>

#include "storage/sqlite/map_rows.h"
#include "storage/sqlite/state.h"
#include "storage/sqlite/stores.h"

namespace freelsd {
namespace {

std::vector<std::string> IdsOf(const std::vector<FlightMapRow>& maps) {
  std::vector<std::string> ids;
  ids.reserve(maps.size());
  for (const FlightMapRow& map : maps) ids.push_back(map.id);
  return ids;
}

}  // namespace

std::string SqliteMapStore::NewId(const std::string& flight_id) {
  const auto lock = state_.LockForWriting();
  Statement statement =
      state_.writer.Prepare("SELECT coalesce(max(number), 0) FROM maps WHERE flight_id = ?1");
  statement.Bind(flight_id).Step();
  int64_t& last = state_.last_map_numbers[flight_id];
  last = std::max({last + 1, statement.Int(0) + 1, state_.first_map_number});
  return flight_id + "/" + std::to_string(last);
}

void SqliteMapStore::Stage(const FlightMapRow& map,
                           const Tiles& tiles,
                           const PhotoTiles& photo_tiles) {
  const auto lock = state_.LockForWriting();
  state_.WriteUnseen([&](const Connection& connection) {
    PutMapRow(connection, map, false);
    PutTileRows(connection, map.id, tiles);
    if (&connection == &state_.writer) PutPhotoTileRows(connection, map.id, photo_tiles);
  });
}

void SqliteMapStore::StageTiles(const std::string& map_id,
                                const Tiles& tiles,
                                const PhotoTiles& photo_tiles) {
  const auto lock = state_.LockForWriting();
  state_.WriteUnseen([&](const Connection& connection) {
    PutTileRows(connection, map_id, tiles);
    if (&connection == &state_.writer) PutPhotoTileRows(connection, map_id, photo_tiles);
  });
}

void SqliteMapStore::Discard(const std::string& map_id) {
  const auto lock = state_.LockForWriting();
  const std::vector<std::string> files = OwnPhotoFiles(state_.writer, {map_id});
  state_.WriteUnseen([&](const Connection& connection) {
    connection.Prepare("DELETE FROM maps WHERE id = ?1 AND is_in_force = 0").Bind(map_id).Run();
  });
  for (const std::string& sha256 : files) state_.images.Remove(sha256);
}

std::vector<FlightMapRow> SqliteMapStore::ListOf(const std::string& flight_id) const {
  return state_.ReadSites(
      [&](const Connection& connection) { return ListMapRowsOf(connection, flight_id); });
}

std::optional<FlightMapRow> SqliteMapStore::Find(const std::string& map_id) const {
  return state_.FindOfSite(
      [&](const Connection& connection) { return FindMapRow(connection, map_id); });
}

std::optional<std::string> SqliteMapStore::ReadTile(const std::string& map_id,
                                                    const TileKey& key) const {
  return state_.ReadSites(
      [&](const Connection& connection) { return ReadTileRow(connection, map_id, key); });
}

std::vector<TileKey> SqliteMapStore::ListTiles(const std::string& map_id) const {
  return state_.ReadSites([&](const Connection& connection) {
    Statement statement = connection.Prepare(
        "SELECT level, row, col FROM map_tiles WHERE map_id = ?1 ORDER BY level, row, col");
    statement.Bind(map_id);
    std::vector<TileKey> keys;
    while (statement.Step()) {
      keys.push_back({statement.Int(0), statement.Int(1), statement.Int(2)});
    }
    return keys;
  });
}

std::optional<std::string> SqliteMapStore::ReadTileCopy(const std::string& map_id,
                                                        const TileKey& key) const {
  return state_.ReadForRecall(
      [&](const Connection& connection) { return ReadTileRow(connection, map_id, key); });
}

std::optional<std::string> SqliteMapStore::FindPhotoTile(const std::string& map_id,
                                                         const TileKey& key) const {
  return state_.ReadSites([&](const Connection& connection) -> std::optional<std::string> {
    Statement statement = connection.Prepare(
        "SELECT sha256 FROM photo_tiles WHERE map_id = ?1 AND level = ?2 AND row = ?3 AND col = "
        "?4");
    if (!statement.Bind(map_id, key.level, key.row, key.col).Step()) return std::nullopt;
    return statement.Text(0);
  });
}

PhotoTiles SqliteMapStore::ListPhotoTiles(const std::string& map_id, int64_t level) const {
  return state_.ReadSites([&](const Connection& connection) {
    Statement statement = connection.Prepare(
        "SELECT row, col, sha256 FROM photo_tiles WHERE map_id = ?1 AND level = ?2 "
        "ORDER BY row, col");
    statement.Bind(map_id, level);
    PhotoTiles tiles;
    while (statement.Step()) {
      tiles.push_back({{level, statement.Int(0), statement.Int(1)}, statement.Text(2)});
    }
    return tiles;
  });
}

std::vector<int64_t> SqliteMapStore::CountPhotoTiles(const std::string& map_id) const {
  return state_.ReadSites([&](const Connection& connection) {
    Statement statement = connection.Prepare(
        "SELECT count(*) FROM photo_tiles WHERE map_id = ?1 GROUP BY level ORDER BY level");
    statement.Bind(map_id);
    std::vector<int64_t> counts;
    while (statement.Step()) counts.push_back(statement.Int(0));
    return counts;
  });
}

void SqliteMapStore::RemovePhotoTiles(const std::string& flight_id) {
  const auto lock = state_.LockForWriting();
  const std::vector<std::string> files =
      OwnPhotoFiles(state_.writer, IdsOf(ListMapRowsOf(state_.writer, flight_id)));
  state_.WriteSites(
      [&](const Connection& connection) { DeletePhotoTileRowsOf(connection, flight_id); });
  for (const std::string& sha256 : files) state_.images.Remove(sha256);
}

std::vector<std::string> SqliteMapStore::ListFlightsWithPhotoTiles() const {
  return state_.ReadSites([](const Connection& connection) {
    Statement statement = connection.Prepare(
        "SELECT flight_id FROM maps WHERE is_in_force = 1 AND "
        "EXISTS (SELECT 1 FROM photo_tiles WHERE map_id = maps.id) "
        "GROUP BY flight_id ORDER BY max(updated_at_us), flight_id");
    std::vector<std::string> ids;
    while (statement.Step()) ids.push_back(statement.Text(0));
    return ids;
  });
}

}  // namespace freelsd
