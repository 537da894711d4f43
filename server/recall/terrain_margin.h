// Height of a path above stored maps. Private to recall.
#pragma once

#include <optional>
#include <vector>

#include "engine/glide/glide.h"
#include "server/recall/altitude_datum.h"
#include "server/recall/recall_sites.h"

namespace freelsd {

// The way where it is nearest to the stored maps below it.
struct TerrainMargin {
  // Height above the map, minus the clearance and what the datum costs, in metres.
  double margin_m = 0.0;
  // Between the datums of the request's altitude and of that map.
  DatumDifference datum;
};

// The map's altitudes, at its middle. Refers to the row's texts.
AltitudeReference ReferenceOf(const MapRow& row, const KeptTerrain& terrain);

// Nothing if no stored map lies below the path. The path has at least one point; altitudes are in
// the request's datum.
std::optional<TerrainMargin> TerrainMarginOf(const StoredSites& stored,
                                             const EmergencyRequest& request,
                                             const std::vector<GeoPoint>& path);

}  // namespace freelsd
