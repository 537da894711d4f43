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
  state_.WriteObstacles([&](const Connection& connection) {
    was_there = DeleteObstacleRow(connection, id) || was_there;
  });
  return was_there;
}

void SqliteObstacleStore::PutFollowed(const std::vector<ObstacleRow>& obstacles,
                                      const std::vector<std::string>& removed) {
  const auto lock = state_.LockForWriting();
  const auto write = [&](const Connection& connection) {
    for (const std::string& id : removed) DeleteObstacleRow(connection, id);
    for (const ObstacleRow& obstacle : obstacles) PutObstacleRow(connection, obstacle);
  };
  state_.WriteObstacles(write, Teller::kAbove);
}

std::optional<ObstacleRow> SqliteObstacleStore::Find(const std::string& id) const {
  for (ObstacleRow& obstacle : List()) {
    if (obstacle.id == id) return std::move(obstacle);
  }
  return std::nullopt;
}

// As recall reads sites: damage can remove rows from the main database undetected.
std::vector<ObstacleRow> SqliteObstacleStore::List() const {
  return state_.ReadForRecall(ListObstacleRows);
}

}  // namespace freelsd
