#include "storage/postgres/state.h"
#include "storage/postgres/stores.h"

namespace freelsd {
namespace {

constexpr char kSelectObstacles[] =
    "SELECT id, feature_json, west_deg, south_deg, east_deg, north_deg, expires_at_us, "
    "updated_at_us FROM obstacles ";

ObstacleRow ObstacleRowOf(const PostgresRow& row) {
  ObstacleRow obstacle;
  obstacle.id = row.Text(0);
  obstacle.feature_json = row.Text(1);
  obstacle.box = {row.Real(2), row.Real(3), row.Real(4), row.Real(5)};
  obstacle.expires_at_us = row.OptionalInt(6);
  obstacle.updated_at_us = row.Int(7);
  return obstacle;
}

void PutObstacle(PostgresConnection& writer, const ObstacleRow& obstacle) {
  writer.Run(
      "INSERT INTO obstacles (id, feature_json, west_deg, south_deg, east_deg, north_deg, "
      "expires_at_us, updated_at_us) VALUES ($1, $2, $3, $4, $5, $6, $7, $8) "
      "ON CONFLICT (id) DO UPDATE SET feature_json = $2, west_deg = $3, south_deg = $4, "
      "east_deg = $5, north_deg = $6, expires_at_us = $7, updated_at_us = $8",
      obstacle.id,
      obstacle.feature_json,
      obstacle.box.west_deg,
      obstacle.box.south_deg,
      obstacle.box.east_deg,
      obstacle.box.north_deg,
      obstacle.expires_at_us,
      obstacle.updated_at_us);
}

}  // namespace

uint64_t PostgresObstacleStore::Version() const { return state_.VersionOf("obstacles"); }

void PostgresObstacleStore::Put(const std::vector<ObstacleRow>& obstacles, int64_t now_us) {
  PostgresWrite writer(state_);
  StepObstacles(*writer);
  writer->Run("DELETE FROM obstacles WHERE expires_at_us < $1", now_us);
  for (const ObstacleRow& obstacle : obstacles) PutObstacle(*writer, obstacle);
  writer.Commit();
}

bool PostgresObstacleStore::Delete(const std::string& id) {
  PostgresWrite writer(state_);
  StepObstacles(*writer);
  const bool was_there = writer->Run("DELETE FROM obstacles WHERE id = $1", id).NumChanges() > 0;
  writer.Commit();
  return was_there;
}

void PostgresObstacleStore::Merge(const ToldObstacles& told) {
  PostgresWrite writer(state_);
  // Whoever writes obstacles waits here for others who do.
  StepObstacles(*writer);
  const auto is_later = [&writer](const std::string& id, int64_t stamp_us) {
    return !writer
                ->Run("SELECT 1 FROM obstacles WHERE id = $1 AND updated_at_us > $2", id, stamp_us)
                .empty();
  };
  for (const ObstacleRemoval& removal : told.removed) {
    if (is_later(removal.id, removal.through_us)) continue;
    writer->Run("DELETE FROM obstacles WHERE id = $1", removal.id);
  }
  for (const ObstacleRow& obstacle : told.stored) {
    if (!is_later(obstacle.id, obstacle.updated_at_us)) PutObstacle(*writer, obstacle);
  }
  writer.Commit();
}

std::optional<ObstacleRow> PostgresObstacleStore::Find(const std::string& id) const {
  return state_.Read([&](PostgresConnection& connection) -> std::optional<ObstacleRow> {
    const PostgresRows rows = connection.Run(std::string(kSelectObstacles) + "WHERE id = $1", id);
    if (rows.empty()) return std::nullopt;
    return ObstacleRowOf(rows[0]);
  });
}

std::vector<ObstacleRow> PostgresObstacleStore::List() const {
  return state_.Read([](PostgresConnection& connection) {
    return connection.Run(std::string(kSelectObstacles) + "ORDER BY id").Each(ObstacleRowOf);
  });
}

}  // namespace freelsd
