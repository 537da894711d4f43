#include "storage/checksum.h"
#include "storage/stores/stores.h"

namespace freelsd {
namespace {

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

std::string SelectObstacles(Database& database, const std::string& which) {
  return std::string(
             "SELECT id, feature_json, west_deg, south_deg, east_deg, north_deg, "
             "expires_at_us, updated_at_us") +
         (database.HasChecksums() ? ", checksum" : "") + " FROM obstacles " + which;
}

auto ObstaclesOf(Database& database) {
  return [is_checked = database.HasChecksums()](const Row& row) {
    ObstacleRow obstacle;
    obstacle.id = row.Text(0);
    obstacle.feature_json = row.Text(1);
    obstacle.box = {row.Real(2), row.Real(3), row.Real(4), row.Real(5)};
    obstacle.expires_at_us = row.OptionalInt(6);
    obstacle.updated_at_us = row.Int(7);
    if (!is_checked || row.Int(8) == ChecksumOf(obstacle)) return obstacle;
    throw StorageError("read an obstacle", "its checksum is wrong", StorageFault::kDamaged);
  };
}

}  // namespace

void PutObstacleRow(Database& writer, const ObstacleRow& obstacle) {
  const bool has_checksum = writer.HasChecksums();
  Values values{obstacle.id,
                obstacle.feature_json,
                obstacle.box.west_deg,
                obstacle.box.south_deg,
                obstacle.box.east_deg,
                obstacle.box.north_deg,
                obstacle.expires_at_us,
                obstacle.updated_at_us};
  if (has_checksum) values.emplace_back(ChecksumOf(obstacle));
  writer.Update(
      std::string("INSERT INTO obstacles (id, feature_json, west_deg, south_deg, east_deg, "
                  "north_deg, expires_at_us, updated_at_us") +
          (has_checksum ? ", checksum" : "") + ") VALUES ($1, $2, $3, $4, $5, $6, $7, $8" +
          (has_checksum ? ", $9" : "") +
          ") ON CONFLICT (id) DO UPDATE SET feature_json = $2, west_deg = $3, south_deg = $4, "
          "east_deg = $5, north_deg = $6, expires_at_us = $7, updated_at_us = $8" +
          (has_checksum ? ", checksum = $9" : ""),
      values);
}

bool DeleteObstacleRow(Database& writer, const std::string& id) {
  return writer.Change("DELETE FROM obstacles WHERE id = $1", id) > 0;
}

std::optional<ObstacleRow> FindObstacleRow(Database& database, const std::string& id) {
  return database.First(ObstaclesOf(database), SelectObstacles(database, "WHERE id = $1"), id);
}

std::vector<ObstacleRow> ListObstacleRows(Database& database) {
  return database.Each(ObstaclesOf(database), SelectObstacles(database, "ORDER BY id"));
}

void SqlObstacleStore::Put(const std::vector<ObstacleRow>& obstacles, int64_t now_us) {
  const auto put = [&](Writer& writer) {
    writer->Change("DELETE FROM obstacles WHERE expires_at_us < $1", now_us);
    for (const ObstacleRow& obstacle : obstacles) PutObstacleRow(*writer, obstacle);
  };
  access_.Write(put, Writing::kObstacles);
}

bool SqlObstacleStore::Delete(const std::string& id) {
  return access_.Write([&](Writer& writer) { return DeleteObstacleRow(*writer, id); },
                       Writing::kObstacles);
}

void SqlObstacleStore::Merge(const ToldObstacles& told) {
  const auto merge = [&](Writer& writer) {
    const auto is_later = [&](const std::string& id, int64_t stamp_us) {
      return writer->Has(
          "SELECT 1 FROM obstacles WHERE id = $1 AND updated_at_us > $2", id, stamp_us);
    };
    for (const ObstacleRemoval& removal : told.removed) {
      if (!is_later(removal.id, removal.through_us)) DeleteObstacleRow(*writer, removal.id);
    }
    for (const ObstacleRow& obstacle : told.stored) {
      if (!is_later(obstacle.id, obstacle.updated_at_us)) PutObstacleRow(*writer, obstacle);
    }
  };
  access_.Write(
      merge, Writing::kObstacles, told.is_from_above ? Teller::kAbove : Teller::kThisServer);
}

std::optional<ObstacleRow> SqlObstacleStore::Find(const std::string& id) const {
  return access_.Read([&](Database& database) { return FindObstacleRow(database, id); },
                      Reading::kRecall);
}

std::vector<ObstacleRow> SqlObstacleStore::List() const {
  return access_.Read(ListObstacleRows, Reading::kRecall);
}

}  // namespace freelsd
