// Height of a path above stored maps. Private to recall.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/glide/glide.h"
#include "server/recall/recall_sites.h"

namespace freelsd {

// Metres to subtract from a height difference of two altitudes whose datums differ or are unknown.
double DatumPenalty(const std::string& given, const std::string& stored);

// Least height of the path above the stored maps below it, minus the clearance, in metres. Nothing
// if no stored map lies below the path. The path has at least one point; altitudes are in the
// request's datum.
std::optional<double> TerrainMargin(const StoredSites& stored,
                                    const EmergencyRequest& request,
                                    const std::vector<GeoPoint>& path);

}  // namespace freelsd
