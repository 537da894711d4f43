// Stored obstacles as recall uses them: parsed once, found by place, set into the frame of a map.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "api/import/obstacles/obstacles.h"
#include "engine/obstacles/obstacles.h"
#include "server/recall/altitude_datum.h"
#include "storage/storage.h"

namespace freelsd {

struct KnownObstacle {
  GivenObstacle given;
  int64_t updated_at_us = 0;
  // Of its geometry and its reach.
  BoundingBox box{};

  // Airspaces are not hard: they only rank a site last.
  bool IsHard() const { return given.kind != ObstacleKind::kNoFly; }
};
using KnownObstacles = SharedRows<KnownObstacle>;

// A box around the place, `reach_m` to each side.
BoundingBox BoxAroundPlace(const GeoPoint& place, double reach_m);

// Thread-safe. It reads all obstacles once for each change of any of them.
class ObstacleCache {
 public:
  // All that have not expired at `now_us` and may meet the box, which may cross the antimeridian.
  // Ordered by id. Throws StorageError: without obstacles nothing can be called safe.
  KnownObstacles Near(const Storage& storage, const BoundingBox& box, int64_t now_us);

 private:
  struct List {
    uint64_t version = 0;
    // By their southern edge.
    std::vector<std::shared_ptr<const KnownObstacle>> from_south;
    double tallest_deg = 0.0;
  };
  std::shared_ptr<const List> Current(const Storage& storage);

  // Guards list_.
  std::mutex mutex_;
  std::shared_ptr<const List> list_;
};

// Ids and updates: two lists with equal keys have the same obstacles.
std::string KeyOf(const KnownObstacles& obstacles);

// Altitude of a top in the datum of `stored`. Where it cannot be converted exactly, it is the
// higher of the possible ones.
double AltitudeIn(const GivenObstacle& obstacle,
                  double altitude_m,
                  const AltitudeReference& stored);

// The hard ones near the origin of a map's frame, in that frame. `map` has the datum of the frame's
// altitudes. Legs are straight in longitude and latitude.
std::vector<HardObstacle> InWorld(const KnownObstacles& obstacles,
                                  const LocalFrame& local_frame,
                                  const AltitudeReference& map);

}  // namespace freelsd
