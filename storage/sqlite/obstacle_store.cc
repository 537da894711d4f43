#include <algorithm>

#include "storage/sqlite/obstacle_rows.h"
#include "storage/sqlite/state.h"
#include "storage/sqlite/stores.h"

namespace freelsd {

uint64_t SqliteObstacleStore::Version() const { return state_.obstacles_version; }

void SqliteObstacleStore::Put(const std::vector<ObstacleRow>& obstacles, int64_t now_us) {
  const auto lock = state_.LockForWriting();
  state_.WriteObstacles([&](const Connection& connection) {
    DeleteExpiredObstacleRows(connection, now_us);
    for (const ObstacleRow& obstacle : obstacles) PutObstacleRow(connection, obstacle);
  });
}

bool SqliteObstacleStore::Delete(const std::string& id) {
  const auto lock = state_.LockForWriting();
  bool was_there = false;
  state_.WriteObstacles(
      [&](const Connection& connection) { was_there = DeleteObstacleRow(connection, id); });
  return was_there;
}

void SqliteObstacleStore::Merge(const ToldObstacles& told) {
  const auto lock = state_.LockForWriting();
  const auto write = [&](const Connection& connection) {
    const auto is_later = [&](const std::string& id, int64_t stamp_us) {
      const std::optional<int64_t> stored_us = FindObstacleStamp(connection, id);
      return stored_us && *stored_us > stamp_us;
    };
    for (const ObstacleRemoval& removal : told.removed) {
      if (!is_later(removal.id, removal.through_us)) DeleteObstacleRow(connection, removal.id);
    }
    for (const ObstacleRow& obstacle : told.stored) {
      if (!is_later(obstacle.id, obstacle.updated_at_us)) PutObstacleRow(connection, obstacle);
    }
  };
  state_.WriteObstacles(write, told.is_from_above ? Teller::kAbove : Teller::kThisServer);
}

std::optional<ObstacleRow> SqliteObstacleStore::Find(const std::string& id) const {
  return state_.ReadForRecall(
      [&](const Connection& connection) { return FindObstacleRow(connection, id); });
}

// As recall reads sites: damage can remove rows from the main database undetected.
std::vector<ObstacleRow> SqliteObstacleStore::List() const {
  return state_.ReadForRecall(ListObstacleRows);
}

}  // namespace freelsd
