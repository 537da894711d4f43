#include "storage/sqlite/obstacle_rows.h"

#include "storage/sqlite/checksum.h"
#include "storage/storage_error.h"

namespace freelsd {
namespace {

constexpr char kSelectObstacles[] =
    "SELECT id, feature_json, west_deg, south_deg, east_deg, north_deg, expires_at_us, "
    "updated_at_us, checksum FROM obstacles ";

int64_t ChecksumOf(const ObstacleRow& obstacle) {
  return Checksum()
      .Add(obstacle.id)
      .Add(obstacle.feature_json)
      .Add(obstacle.box.west_deg)
      .Add(obstacle.box.south_deg)
      .Add(obstacle.box.east_deg)
      .Add(obstacle.box.north_deg)
      .Add(obstacle.expires_at_us.value_or(0))
      .Add(obstacle.updated_at_us)
      .value();
}

ObstacleRow RowOf(const Statement& statement) {
  ObstacleRow obstacle;
  obstacle.id = statement.Text(0);
  obstacle.feature_json = statement.Text(1);
  obstacle.box = {statement.Real(2), statement.Real(3), statement.Real(4), statement.Real(5)};
  obstacle.expires_at_us = statement.OptionalInt(6);
  obstacle.updated_at_us = statement.Int(7);
  if (statement.Int(8) == ChecksumOf(obstacle)) return obstacle;
  throw StorageError("read an obstacle", "its checksum is wrong", StorageFault::kDamaged);
}

}  // namespace

void PutObstacleRow(const Connection& writer, const ObstacleRow& obstacle) {
  writer
      .Prepare(
          "INSERT OR REPLACE INTO obstacles (id, feature_json, west_deg, south_deg, east_deg, "
          "north_deg, expires_at_us, updated_at_us, checksum) VALUES (?1, ?2, ?3, ?4, ?5, ?6, "
          "nullif(?7, 0), ?8, ?9)")
      .Bind(obstacle.id,
            obstacle.feature_json,
            obstacle.box.west_deg,
            obstacle.box.south_deg,
            obstacle.box.east_deg,
            obstacle.box.north_deg,
            obstacle.expires_at_us.value_or(0),
            obstacle.updated_at_us,
            ChecksumOf(obstacle))
      .Run();
}

bool DeleteObstacleRow(const Connection& writer, const std::string& id) {
  writer.Prepare("DELETE FROM obstacles WHERE id = ?1").Bind(id).Run();
  return writer.NumChanges() > 0;
}

std::optional<int64_t> FindObstacleStamp(const Connection& connection, const std::string& id) {
  Statement statement = connection.Prepare("SELECT updated_at_us FROM obstacles WHERE id = ?1");
  statement.Bind(id);
  if (!statement.Step()) return std::nullopt;
  return statement.Int(0);
}

std::optional<ObstacleRow> FindObstacleRow(const Connection& connection, const std::string& id) {
  Statement statement =
      connection.Prepare((std::string(kSelectObstacles) + "WHERE id = ?1").c_str());
  statement.Bind(id);
  if (!statement.Step()) return std::nullopt;
  return RowOf(statement);
}

void DeleteExpiredObstacleRows(const Connection& writer, int64_t now_us) {
  writer.Prepare("DELETE FROM obstacles WHERE expires_at_us < ?1").Bind(now_us).Run();
}

std::vector<ObstacleRow> ListObstacleRows(const Connection& connection) {
  Statement statement = connection.Prepare((std::string(kSelectObstacles) + "ORDER BY id").c_str());
  std::vector<ObstacleRow> obstacles;
  while (statement.Step()) obstacles.push_back(RowOf(statement));
  return obstacles;
}

ObstacleStamps ObstacleStampsOf(const Connection& connection) {
  Statement statement = connection.Prepare("SELECT id, checksum FROM obstacles");
  ObstacleStamps stamps;
  while (statement.Step()) stamps[statement.Text(0)] = statement.Int(1);
  return stamps;
}

}  // namespace freelsd
