// Stored obstacles on the grid of reach. Private to reach/.
#pragma once

#include "server/recall/obstacles/obstacles.h"
#include "server/recall/reach/reach_ground.h"

namespace freelsd {

struct EmergencyRequest;

// Raises the ground to the tops of the hard obstacles among these, as far as the position's
// deviation and half of the aircraft's corridor reach. Maps have obstacles in their ground already;
// a top whose altitude is unknown is therefore added only where no map is.
void AddObstacles(const KnownObstacles& obstacles,
                  const EmergencyRequest& request,
                  const ReachFrame& frame,
                  double path_half_width_m,
                  NearbyGround& nearby);

}  // namespace freelsd
