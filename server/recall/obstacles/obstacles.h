// Stored obstacles as recall uses them: parsed once, found by place, set into the frame of a map;
// what they make of stored plans, and of a way through the air.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "api/import/obstacles/obstacles.h"
#include "engine/obstacles/obstacles.h"
#include "server/recall/altitude_datum.h"
#include "storage/storage.h"

namespace freelsd {

constexpr double kMetresPerDegree = 111195.0;  // of latitude, on a sphere

struct EmergencyRequest;
struct StoredSites;

// --- Obstacles near a place ---

struct KnownObstacle {
  GivenObstacle given;
  int64_t updated_at_us = 0;
  // Of its geometry and its reach.
  BoundingBox box{};

  // Airspaces are not hard: they only rank a site last.
  bool IsHard() const {
    return given.kind != ObstacleKind::kNoFly && given.kind != ObstacleKind::kWiresKnown;
  }
};
using KnownObstacles = SharedRows<KnownObstacle>;

// A box around the place, `reach_m` to each side.
BoundingBox BoxAroundPlace(const GeoPoint& place, double reach_m);
// The points' own box, which does not cross the antimeridian.
BoundingBox BoxOfPoints(const std::vector<GeoPoint>& points);

// Thread-safe. It reads all obstacles once for each change of any of them.
class ObstacleCache {
 public:
  // All that have not expired at `now_us` and may meet the box, which may cross the antimeridian.
  // Ordered by id. Throws StorageError: without obstacles nothing can be called safe.
  KnownObstacles Near(const Storage& storage, const BoundingBox& box, int64_t now_us);
  // When the next of all obstacles expires; nothing if none does.
  std::optional<int64_t> NextExpiryUs(const Storage& storage, int64_t now_us);

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

// No map reaches farther from the origin of its frame.
constexpr double kFarFromMapM = 10000.0;

// The hard ones in a frame, without points that are farther than `far_m` from its origin. `map` has
// the datum of the frame's altitudes. Legs are straight in longitude and latitude.
std::vector<HardObstacle> InWorld(const KnownObstacles& obstacles,
                                  const LocalFrame& local_frame,
                                  const AltitudeReference& map,
                                  double far_m = kFarFromMapM);

// --- Stored plans ---

// What obstacles make of a stored plan: the broken rule, as reject_reason, a sentence with numbers,
// and the obstacles that break it.
struct Obstruction {
  std::string reason;
  std::string detail;
  std::vector<std::string> obstacle_ids;
};

// A site whose stored plan meets an obstacle is no landing site for as long as the obstacle is
// there. Nothing of it is stored, so that the site is back by itself.
//
// Nothing if the site was rejected anyway, or if its plan holds. Cached.
std::optional<Obstruction> ObstructionOf(const StoredSites& stored, const SiteRow& site);
// The row, its feature rejected if its plan meets an obstacle: verdict, reject_reason,
// reject_detail, blocked_by, summary and why; what told how good it is, is null, its score 0.
SiteRow AsObstructed(const StoredSites& stored, SiteRow site);

// --- Ways through the air ---

// The way where it is nearest above the top of an obstacle.
struct ObstacleMargin {
  // Height above the top, minus the clearance, in metres. Below a wire it is negative.
  double margin_m = 0.0;
  std::string obstacle_id;
};

struct PathObstacles {
  // Of those whose top is known. Nothing if the path passes over none.
  std::optional<ObstacleMargin> least;
  // Ids of those that the path passes over where neither their top nor the ground is known.
  std::vector<std::string> of_unknown_top;
  // Ids of the airspaces that the path enters, and their names where they have one, else their ids.
  std::vector<std::string> airspaces;
  std::vector<std::string> airspace_names;
  // Wires are known along the whole path.
  bool are_wires_known = false;
};

// A way to a touchdown; altitudes are in the request's datum.
struct CheckedPath {
  // To the start of the final: the planner has not checked it.
  std::vector<GeoPoint> transit;
  // The circle and the final, which the planner has checked for all but airspaces.
  std::vector<GeoPoint> landing;
  // Half of the corridor that must be clear.
  double half_width_m = 0.0;
};

// True if each of the places lies in an area whose wires are known.
bool AreWiresKnown(const StoredSites& stored, const std::vector<GeoPoint>& places);

PathObstacles ObstaclesAlong(const StoredSites& stored,
                             const EmergencyRequest& request,
                             const CheckedPath& path);

}  // namespace freelsd
