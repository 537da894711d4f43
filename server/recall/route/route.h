// Landing insurance of a planned flight: for each second of it, which stored site an aircraft whose
// engine stops there can reach, by emergency recall's own search.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "api/import/routes/routes.h"
#include "server/recall/recall_sites.h"

namespace freelsd {

// {covered_ratio, length_m, time_s, gaps, point_of_no_return?, fixes, samples, warnings}. The
// heading of each recall is the direction of the leg. A second counts as covered if a site is in
// reach in each of the winds. Thread-safe; uses all processors. Throws ApiError if the route cannot
// be flown or is too long.
nlohmann::json CheckRoute(const StoredSites& stored, const RouteRequest& request);

// The same answer as a GeoJSON FeatureCollection. Lines of kind `covered` and `gap` follow each
// other; points of kind `point_of_no_return` and `look`; lines of kind `climb` and `offset`.
// Colours as in simplestyle.
nlohmann::json RouteGeoJson(const nlohmann::json& answer);

}  // namespace freelsd
