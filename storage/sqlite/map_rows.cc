#include "storage/sqlite/map_rows.h"

#include <charconv>
#include <set>

#include "storage/boxes.h"
#include "storage/sqlite/checksum.h"
#include "storage/storage_error.h"

namespace freelsd {
namespace {

constexpr char kSelect[] =
    "SELECT id, flight_id, head_json, altitude_datum, west_deg, south_deg, east_deg, north_deg, "
    "updated_at_us, seen_at_us, checksum, seen_until_us FROM maps ";

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

Statement SelectMaps(const Connection& connection, const std::string& which) {
  return connection.Prepare((kSelect + which).c_str());
}

FlightMapRow MapRowOf(const Statement& statement) {
  FlightMapRow map;
  map.id = statement.Text(0);
  map.flight_id = statement.Text(1);
  map.head_json = statement.Text(2);
  map.altitude_datum = statement.Text(3);
  map.box = {statement.Real(4), statement.Real(5), statement.Real(6), statement.Real(7)};
  map.updated_at_us = statement.Int(8);
  map.seen_at_us = statement.Int(9);
  map.seen_until_us = statement.OptionalInt(11);
  if (statement.Int(10) == ChecksumOf(map)) return map;
  throw StorageError("read a map", "its checksum is wrong", StorageFault::kDamaged);
}

// The number at the end of '<flight>/<number>'.
int64_t NumberOf(const std::string& map_id) {
  int64_t number = 0;
  const char* const end = map_id.data() + map_id.size();
  std::from_chars(map_id.data() + map_id.rfind('/') + 1, end, number);
  return number;
}

}  // namespace

void PutMapRow(const Connection& writer, const FlightMapRow& map, bool is_in_force) {
  writer
      .Prepare(
          "INSERT INTO maps (id, flight_id, number, head_json, altitude_datum, west_deg, "
          "south_deg, east_deg, north_deg, updated_at_us, seen_at_us, is_in_force, checksum, "
          "seen_until_us) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, "
          "nullif(?14, 0))")
      .Bind(map.id,
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
            static_cast<int>(is_in_force),
            ChecksumOf(map),
            map.seen_until_us.value_or(0))
      .Run();
}

void PutTileRows(const Connection& writer, const std::string& map_id, const Tiles& tiles) {
  for (const auto& [key, tile] : tiles) {
    writer.Prepare("INSERT OR REPLACE INTO map_tiles VALUES (?1, ?2, ?3, ?4, ?5)")
        .Bind(map_id, key.level, key.row, key.col, Blob{tile})
        .Run();
  }
}

void PutPhotoTileRows(const Connection& writer,
                      const std::string& map_id,
                      const PhotoTiles& photo_tiles) {
  for (const auto& [key, sha256] : photo_tiles) {
    writer.Prepare("INSERT OR REPLACE INTO photo_tiles VALUES (?1, ?2, ?3, ?4, ?5)")
        .Bind(map_id, key.level, key.row, key.col, sha256)
        .Run();
  }
}

void PutMapInForce(const Connection& writer, const std::string& map_id) {
  writer.Prepare("UPDATE maps SET is_in_force = 1 WHERE id = ?1").Bind(map_id).Run();
}

void DeleteMapRow(const Connection& writer, const std::string& map_id) {
  writer.Prepare("DELETE FROM maps WHERE id = ?1").Bind(map_id).Run();
}

void DeleteUnfinishedMaps(const Connection& writer) {
  {
    // Usually there is none, and nothing is written.
    Statement unfinished = writer.Prepare("SELECT 1 FROM maps WHERE is_in_force = 0 LIMIT 1");
    if (!unfinished.Step()) return;
  }
  writer.Execute("DELETE FROM maps WHERE is_in_force = 0");
}

void DeletePhotoTileRowsOf(const Connection& writer, const std::string& flight_id) {
  writer
      .Prepare("DELETE FROM photo_tiles WHERE map_id IN (SELECT id FROM maps WHERE flight_id = ?1)")
      .Bind(flight_id)
      .Run();
}

std::vector<FlightMapRow> ListMapRowsOf(const Connection& connection,
                                        const std::string& flight_id) {
  Statement statement =
      SelectMaps(connection, "WHERE flight_id = ?1 AND is_in_force = 1 ORDER BY number DESC");
  statement.Bind(flight_id);
  std::vector<FlightMapRow> maps;
  while (statement.Step()) maps.push_back(MapRowOf(statement));
  return maps;
}

std::optional<FlightMapRow> FindMapRow(const Connection& connection, const std::string& map_id) {
  Statement statement = SelectMaps(connection, "WHERE id = ?1");
  if (!statement.Bind(map_id).Step()) return std::nullopt;
  return MapRowOf(statement);
}

std::optional<std::string> ReadTileRow(const Connection& connection,
                                       const std::string& map_id,
                                       const TileKey& key) {
  Statement statement = connection.Prepare(
      "SELECT tile FROM map_tiles WHERE map_id = ?1 AND level = ?2 AND row = ?3 AND col = ?4");
  if (!statement.Bind(map_id, key.level, key.row, key.col).Step()) return std::nullopt;
  return statement.Text(0);
}

BoxCache<MapRow>::Rows ListMapRows(const Connection& connection, const BoundingBox& box) {
  Statement statement = SelectMaps(connection,
                                   "WHERE is_in_force = 1 AND south_deg <= ?4 AND north_deg >= ?2 "
                                   "AND CASE WHEN west_deg <= east_deg "
                                   "THEN west_deg <= ?3 AND east_deg >= ?1 "
                                   "ELSE west_deg <= ?3 OR east_deg >= ?1 END ORDER BY id");
  statement.Bind(box.west_deg, box.south_deg, box.east_deg, box.north_deg);
  BoxCache<MapRow>::Rows rows;
  while (statement.Step()) {
    const FlightMapRow map = MapRowOf(statement);
    rows.push_back({map.box, std::make_shared<const MapRow>(RowOf(map))});
  }
  return rows;
}

bool IsImageNeeded(const Connection& connection, const std::string& sha256) {
  Statement statement = connection.Prepare(
      "SELECT EXISTS (SELECT 1 FROM frames WHERE sha256 = ?1) OR "
      "EXISTS (SELECT 1 FROM photo_tiles WHERE sha256 = ?1)");
  statement.Bind(sha256).Step();
  return statement.Int(0) != 0;
}

std::vector<std::string> OwnPhotoFiles(const Connection& connection,
                                       const std::vector<std::string>& map_ids) {
  const std::set<std::string> ids(map_ids.begin(), map_ids.end());
  std::set<std::string> files;
  for (const std::string& id : ids) {
    Statement statement =
        connection.Prepare("SELECT DISTINCT sha256 FROM photo_tiles WHERE map_id = ?1");
    statement.Bind(id);
    while (statement.Step()) files.insert(statement.Text(0));
  }
  std::vector<std::string> own;
  for (const std::string& sha256 : files) {
    bool is_shared = false;
    Statement users =
        connection.Prepare("SELECT DISTINCT map_id FROM photo_tiles WHERE sha256 = ?1");
    users.Bind(sha256);
    while (users.Step()) is_shared = is_shared || !ids.contains(users.Text(0));
    Statement frames = connection.Prepare("SELECT 1 FROM frames WHERE sha256 = ?1 LIMIT 1");
    if (!is_shared && !frames.Bind(sha256).Step()) own.push_back(sha256);
  }
  return own;
}

void CheckMapRows(const Connection& connection) {
  Statement statement = SelectMaps(connection, "");
  while (statement.Step()) MapRowOf(statement);
}

std::optional<MapContent> MapContentOf(const Connection& connection, const std::string& map_id) {
  Statement statement = connection.Prepare(
      "SELECT checksum, is_in_force, (SELECT count(*) FROM map_tiles WHERE map_id = id) "
      "FROM maps WHERE id = ?1");
  if (!statement.Bind(map_id).Step()) return std::nullopt;
  return MapContent{statement.Int(0), statement.Int(1) != 0, statement.Int(2)};
}

MapStamps MapStampsOf(const Connection& connection) {
  Statement statement = connection.Prepare("SELECT id, checksum FROM maps WHERE is_in_force = 1");
  MapStamps stamps;
  while (statement.Step()) stamps[statement.Text(0)] = statement.Int(1);
  return stamps;
}

}  // namespace freelsd
