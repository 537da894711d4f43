#include <charconv>
#include <set>

#include "storage/checksum.h"
#include "storage/stores/stores.h"

namespace freelsd {
namespace {

int64_t ChecksumOf(const FlightMapRow& map) {
  Checksum checksum;
  if (map.seen_until_us) checksum.Add(*map.seen_until_us);
  return checksum.Add(map.id)
      .Add(map.flight_id)
      .Add(map.head_json)
      .Add(map.altitude_datum)
      .Add(map.box.west_deg)
      .Add(map.box.south_deg)
      .Add(map.box.east_deg)
      .Add(map.box.north_deg)
      .Add(map.updated_at_us)
      .Add(map.seen_at_us)
      .value();
}

FlightMapRow MapRowOf(const Row& row) {
  FlightMapRow map;
  map.id = row.Text(0);
  map.flight_id = row.Text(1);
  map.head_json = row.Text(2);
  map.altitude_datum = row.Text(3);
  map.box = BoxAt(row, 4);
  map.updated_at_us = row.Int(8);
  map.seen_at_us = row.Int(9);
  map.seen_until_us = row.OptionalInt(10);
  return map;
}

// The number at the end of '<flight>/<number>'.
int64_t NumberOf(const std::string& map_id) {
  int64_t number = 0;
  const char* const end = map_id.data() + map_id.size();
  std::from_chars(map_id.data() + map_id.rfind('/') + 1, end, number);
  return number;
}

std::optional<std::string> FindTile(Database& database,
                                    const std::string& select,
                                    const std::string& map_id,
                                    const TileKey& key) {
  return database.First([](const Row& row) { return row.Text(0); },
                        select + " WHERE map_id = $1 AND level = $2 AND row = $3 AND col = $4",
                        map_id,
                        key.level,
                        key.row,
                        key.col);
}

std::optional<std::string> FindMapTile(Database& database,
                                       const std::string& map_id,
                                       const TileKey& key) {
  return FindTile(database, "SELECT tile FROM map_tiles", map_id, key);
}

}  // namespace

void PutMapRow(Database& writer, const FlightMapRow& map, bool is_in_force) {
  const bool has_checksum = writer.HasChecksums();
  Values values{map.id,
                map.flight_id,
                NumberOf(map.id),
                map.head_json,
                map.altitude_datum,
                map.box.west_deg,
                map.box.south_deg,
                map.box.east_deg,
                map.box.north_deg,
                map.updated_at_us,
                map.seen_at_us,
                is_in_force,
                map.seen_until_us};
  if (has_checksum) values.emplace_back(ChecksumOf(map));
  writer.Update(
      std::string("INSERT INTO maps (id, flight_id, number, head_json, altitude_datum, west_deg, "
                  "south_deg, east_deg, north_deg, updated_at_us, seen_at_us, is_in_force, "
                  "seen_until_us") +
          (has_checksum ? ", checksum" : "") +
          ") VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13" +
          (has_checksum ? ", $14)" : ")"),
      values);
}

void PutTileRows(Database& writer, const std::string& map_id, const Tiles& tiles) {
  for (const auto& [key, tile] : tiles) {
    writer.Change(
        "INSERT INTO map_tiles (map_id, level, row, col, tile) VALUES ($1, $2, $3, $4, $5) "
        "ON CONFLICT (map_id, level, row, col) DO UPDATE SET tile = $5",
        map_id,
        key.level,
        key.row,
        key.col,
        Blob{tile});
  }
}

void PutMapInForce(Database& writer, const std::string& map_id) {
  writer.Change("UPDATE maps SET is_in_force = true WHERE id = $1", map_id);
}

void DeleteMapRow(Database& writer, const std::string& map_id) {
  writer.Change("DELETE FROM maps WHERE id = $1", map_id);
}

void ForEachMapRow(Database& database,
                   const std::string& which,
                   const Values& values,
                   const std::function<void(const FlightMapRow&)>& visit) {
  const bool has_checksum = database.HasChecksums();
  const std::string select =
      std::string(
          "SELECT id, flight_id, head_json, altitude_datum, west_deg, south_deg, "
          "east_deg, north_deg, updated_at_us, seen_at_us, seen_until_us") +
      (has_checksum ? ", checksum" : "") + " FROM maps ";
  database.Select(select + which, values, [&](const Row& row) {
    const FlightMapRow map = MapRowOf(row);
    if (has_checksum && row.Int(11) != ChecksumOf(map)) {
      throw StorageError("read a map", "its checksum is wrong", StorageFault::kDamaged);
    }
    visit(map);
    return true;
  });
}

std::optional<FlightMapRow> FindMapRow(Database& database, const std::string& map_id) {
  std::optional<FlightMapRow> found;
  ForEachMapRow(
      database, "WHERE id = $1", {map_id}, [&found](const FlightMapRow& map) { found = map; });
  return found;
}

void SqlMapStore::PutTiles(Writer& writer,
                           const std::string& map_id,
                           const Tiles& tiles,
                           const PhotoTiles& photo_tiles) {
  PutTileRows(*writer, map_id, tiles);
  // The images are no part of the second copy.
  if (writer.is_second_copy) return;
  queries_.put_images_to_come(*writer, photo_tiles);
  for (const auto& [key, sha256] : photo_tiles) {
    writer->Change(
        "INSERT INTO photo_tiles (map_id, level, row, col, sha256) VALUES ($1, $2, $3, $4, $5) "
        "ON CONFLICT (map_id, level, row, col) DO UPDATE SET sha256 = $5",
        map_id,
        key.level,
        key.row,
        key.col,
        sha256);
  }
}

std::string SqlMapStore::NewId(const std::string& flight_id) {
  return flight_id + "/" + std::to_string(access_.NextMapNumber(flight_id));
}

void SqlMapStore::Stage(const FlightMapRow& map,
                        const Tiles& tiles,
                        const PhotoTiles& photo_tiles) {
  const auto stage = [&](Writer& writer) {
    PutMapRow(*writer, map, false);
    queries_.put_area(*writer, map);
    PutTiles(writer, map.id, tiles, photo_tiles);
  };
  access_.Write(stage, Writing::kUnseenMaps);
}

void SqlMapStore::StageTiles(const std::string& map_id,
                             const Tiles& tiles,
                             const PhotoTiles& photo_tiles) {
  access_.Write([&](Writer& writer) { PutTiles(writer, map_id, tiles, photo_tiles); },
                Writing::kUnseenMaps);
}

void SqlMapStore::Discard(const std::string& map_id) {
  const auto discard = [&](Writer& writer) {
    writer.unused_images =
        writer->Texts("SELECT DISTINCT sha256 FROM photo_tiles WHERE map_id = $1", map_id);
    writer->Change("DELETE FROM maps WHERE id = $1 AND is_in_force = false", map_id);
  };
  access_.Write(discard, Writing::kUnseenMaps);
}

std::vector<FlightMapRow> SqlMapStore::ListOf(const std::string& flight_id) const {
  const auto list = [&](Database& database) {
    std::vector<FlightMapRow> maps;
    ForEachMapRow(database,
                  "WHERE flight_id = $1 AND is_in_force = true ORDER BY number DESC",
                  {flight_id},
                  [&maps](const FlightMapRow& map) { maps.push_back(map); });
    return maps;
  };
  return access_.Read(list, Reading::kSites);
}

std::optional<FlightMapRow> SqlMapStore::Find(const std::string& map_id) const {
  return access_.FindInEither([&](Database& database) { return FindMapRow(database, map_id); });
}

std::optional<std::string> SqlMapStore::ReadTile(const std::string& map_id,
                                                 const TileKey& key) const {
  return access_.Read([&](Database& database) { return FindMapTile(database, map_id, key); },
                      Reading::kSites);
}

std::optional<std::string> SqlMapStore::ReadTileCopy(const std::string& map_id,
                                                     const TileKey& key) const {
  return access_.Read([&](Database& database) { return FindMapTile(database, map_id, key); },
                      Reading::kRecall);
}

std::vector<TileKey> SqlMapStore::ListTiles(const std::string& map_id) const {
  const auto list = [&](Database& database) {
    return database.Each(
        [](const Row& row) {
          return TileKey{row.Int(0), row.Int(1), row.Int(2)};
        },
        "SELECT level, row, col FROM map_tiles WHERE map_id = $1 ORDER BY level, row, col",
        map_id);
  };
  return access_.Read(list, Reading::kSites);
}

std::optional<std::string> SqlMapStore::FindPhotoTile(const std::string& map_id,
                                                      const TileKey& key) const {
  const auto find = [&](Database& database) {
    return FindTile(database, "SELECT sha256 FROM photo_tiles", map_id, key);
  };
  return access_.Read(find, Reading::kSites);
}

PhotoTiles SqlMapStore::ListPhotoTiles(const std::string& map_id, int64_t level) const {
  const auto list = [&](Database& database) {
    return database.Each(
        [level](const Row& row) {
          return std::pair(TileKey{level, row.Int(0), row.Int(1)}, row.Text(2));
        },
        "SELECT row, col, sha256 FROM photo_tiles WHERE map_id = $1 AND level = $2 "
        "ORDER BY row, col",
        map_id,
        level);
  };
  return access_.Read(list, Reading::kSites);
}

std::vector<int64_t> SqlMapStore::CountPhotoTiles(const std::string& map_id) const {
  const auto count = [&](Database& database) {
    return database.Each(
        [](const Row& row) { return row.Int(0); },
        "SELECT count(*) FROM photo_tiles WHERE map_id = $1 GROUP BY level ORDER BY level",
        map_id);
  };
  return access_.Read(count, Reading::kSites);
}

void SqlMapStore::RemovePhotoTiles(const std::string& flight_id) {
  const auto remove = [&](Writer& writer) {
    writer.unused_images = writer->Texts(
        "DELETE FROM photo_tiles WHERE map_id IN (SELECT id FROM maps WHERE flight_id = $1) "
        "RETURNING sha256",
        flight_id);
  };
  access_.Write(remove, Writing::kSites);
}

std::vector<std::string> SqlMapStore::ListFlightsWithPhotoTiles() const {
  const auto list = [](Database& database) {
    return database.Texts(
        "SELECT flight_id FROM maps WHERE is_in_force = true AND "
        "EXISTS (SELECT 1 FROM photo_tiles WHERE map_id = maps.id) "
        "GROUP BY flight_id ORDER BY max(updated_at_us), flight_id");
  };
  return access_.Read(list, Reading::kSites);
}

}  // namespace freelsd
