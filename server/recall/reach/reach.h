// The ground that an aircraft without power can reach, over stored maps.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "server/recall/emergency_request.h"
#include "server/recall/reach/reach_ground.h"
#include "server/recall/recall_sites.h"

namespace freelsd {

// A FeatureCollection: features of kind reach, unknown_terrain and site. The sites and their
// margins are those of RecallSites. Thread-safe.
nlohmann::json ReachFrom(const StoredSites& stored,
                         GroundPatches& patches,
                         const EmergencyRequest& request);

}  // namespace freelsd
