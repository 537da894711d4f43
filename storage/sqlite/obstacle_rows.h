// SQL for rows of obstacles, on a connection to the main database or to the second copy.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "storage/obstacle_store.h"
#include "storage/sqlite/sqlite.h"

namespace freelsd {

void PutObstacleRow(const Connection& writer, const ObstacleRow& obstacle);
// True if it existed.
bool DeleteObstacleRow(const Connection& writer, const std::string& id);
// Throws StorageError kDamaged if its checksum is wrong.
std::optional<ObstacleRow> FindObstacleRow(const Connection& connection, const std::string& id);
// Its updated_at_us.
std::optional<int64_t> FindObstacleStamp(const Connection& connection, const std::string& id);
void DeleteExpiredObstacleRows(const Connection& writer, int64_t now_us);
// Throws StorageError kDamaged if a checksum is wrong.
std::vector<ObstacleRow> ListObstacleRows(const Connection& connection);

// Checksums by id.
using ObstacleStamps = std::map<std::string, int64_t>;
ObstacleStamps ObstacleStampsOf(const Connection& connection);

}  // namespace freelsd
