// Height of a path above stored maps. Private to recall.
#pragma once

#include <optional>
#include <vector>

#include "engine/glide/glide.h"
#include "server/recall/altitude_datum.h"
#include "server/recall/recall_sites.h"

namespace freelsd {

// The point of the path with the least height above the stored maps.
struct TerrainMargin {
  // Height above the map, minus the request's terrain clearance and minus datum.subtracted_m;
  // metres.
  double margin_m = 0.0;
  // Difference between the datum of the request's altitude and the datum of the map.
  DatumDifference datum;
};

// Nothing if no stored map lies below the path. `path` has at least one point. Its altitudes are in
// the request's datum.
std::optional<TerrainMargin> TerrainMarginOf(const StoredSites& stored,
                                             const EmergencyRequest& request,
                                             const std::vector<GeoPoint>& path);

}  // namespace freelsd
