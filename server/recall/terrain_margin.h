// Height of a path above stored maps. Private to recall.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "engine/footprint/footprint.h"
#include "engine/glide/glide.h"
#include "server/recall/altitude_datum.h"
#include "server/recall/recall_sites.h"

namespace freelsd {

// The point of the path with the least height above the stored maps.
struct TerrainMargin {
  // Height above the map in metres, minus datum.subtracted_m.
  double margin_m = 0.0;
  // Difference between the datum of the request's altitude and the datum of the map.
  DatumDifference datum;
};

// The map's altitudes, at its middle. Refers to the row's texts.
AltitudeReference ReferenceOf(const MapRow& row, const KeptTerrain& terrain);

// A stored map that a path may cross.
struct MapBelow {
  std::shared_ptr<const KeptTerrain> terrain;
  // From the datum of the request's altitudes to the map's.
  DatumDifference datum;
};
// Without maps that cannot be read, or that do not count for the request's flight. The path has at
// least one point.
std::vector<MapBelow> MapsBelow(const StoredSites& stored,
                                const EmergencyRequest& request,
                                const std::vector<GeoPoint>& path);

// Altitudes between which the ground lies, in the request's datum: of the blocks around the place,
// which have the height of what stands on them, of all maps that have seen it. Nothing if none has.
std::optional<HeightRange> GroundAltitudesAt(const std::vector<MapBelow>& maps,
                                             const GeoPoint& place);

// Terrain of the map that the site lies on. Nothing if it has none, or if it cannot be read.
std::shared_ptr<const KeptTerrain> TerrainBelow(const StoredSites& stored, const RecallRow& site);

// Nothing if no stored map lies below the path. The path has at least one point. Its altitudes are
// in the request's datum. The caller has lowered them by the clearance that is to be kept.
std::optional<TerrainMargin> TerrainMarginOf(const StoredSites& stored,
                                             const EmergencyRequest& request,
                                             const std::vector<GeoPoint>& path);

// True if the map has seen all ground below a line, sampled every half cell. Both ends are in the
// world frame of the map.
bool IsSeenBelow(const KeptTerrain& terrain,
                 const Eigen::Vector3d& begin_in_world,
                 const Eigen::Vector3d& end_in_world);

}  // namespace freelsd
