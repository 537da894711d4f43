// GeoJSON as it leaves the server.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace freelsd {

// RFC 7946, 3.1.9: a line or polygon across the antimeridian is cut there, into a MultiLineString
// or MultiPolygon; the ends of both parts have the longitudes 180 and -180 degrees. All else stays.
// `geojson` is a geometry, a Feature or a FeatureCollection. The longitudes of a leg across differ
// by more than 180 degrees, or go on beyond 180 degrees. Further numbers of a position are
// interpolated. A ring around a pole stays as it is.
nlohmann::json CutAtAntimeridian(nlohmann::json geojson);

}  // namespace freelsd
