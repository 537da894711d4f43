// Obstacles that photographs do not show: wires, masts, airspaces, people.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "storage/site_store.h"

namespace freelsd {

// Columns and units are those of schema.sql.
struct ObstacleRow {
  std::string id;
  // GeoJSON feature as the parser wrote it.
  std::string feature_json;
  // WGS84; never crosses the antimeridian.
  BoundingBox box{};
  // When it stops to count; nothing: never.
  std::optional<int64_t> expires_at_us;
  int64_t updated_at_us = 0;
};

// The end of an obstacle as it was up to that time; a later one stays.
struct ObstacleRemoval {
  std::string id;
  int64_t through_us = 0;
};

// What another server told.
struct ToldObstacles {
  std::vector<ObstacleRow> stored;
  std::vector<ObstacleRemoval> removed;
  // The server that this one follows told it (ChangeRow::is_known_above).
  bool is_from_above = false;
};

// Invariant of SQLite: each obstacle is stored in two databases, as sites are: a lost obstacle
// would make a place look safe.
class ObstacleStore {
 public:
  virtual ~ObstacleStore() = default;
  ObstacleStore(const ObstacleStore&) = delete;
  ObstacleStore& operator=(const ObstacleStore&) = delete;

  // Inserts or replaces all, in one commit, and removes those that expired before now_us.
  virtual void Put(const std::vector<ObstacleRow>& obstacles, int64_t now_us) = 0;
  // False if there is no such obstacle.
  virtual bool Delete(const std::string& id) = 0;
  // In one commit, each unless a later version is stored by then.
  virtual void Merge(const ToldObstacles& told) = 0;

  // Expired ones included, if no write has removed them yet.
  virtual std::optional<ObstacleRow> Find(const std::string& id) const = 0;
  // Ordered by id.
  virtual std::vector<ObstacleRow> List() const = 0;
  // Increases with every change of any obstacle, before the change returns.
  virtual uint64_t Version() const = 0;

 protected:
  ObstacleStore() = default;
};

}  // namespace freelsd
