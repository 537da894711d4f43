// Obstacles along a path through the air, also where no map is. Private to recall.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "server/recall/emergency_request.h"
#include "server/recall/recall_sites.h"

namespace freelsd {

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
  // Ids of the airspaces that the path enters.
  std::vector<std::string> airspaces;
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

PathObstacles ObstaclesAlong(const StoredSites& stored,
                             const EmergencyRequest& request,
                             const CheckedPath& path);

}  // namespace freelsd
