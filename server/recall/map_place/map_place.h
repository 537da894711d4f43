// Any place on the maps of a flight, to be planned and judged like a site.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/recall/map_cache.h"
#include "server/recall/recall_sites.h"

namespace freelsd {

// A landing is searched within this distance of the place.
constexpr double kLandingRadiusM = 100.0;

// The newest map of the flight that has seen the place, else the newest one that it lies on.
// Nothing if it lies on none.
std::shared_ptr<const FlightMap> MapAt(const StoredSites& stored,
                                       const std::string& flight_id,
                                       const GeoPoint& place);

// The ground around the place as a site whose region is a disc of radius kLandingRadiusM. Its area
// is that of the free ground in the disc, and its observations are the photographs that see the
// place. The map reaches far enough for this aircraft, and for the given winds, or if there are
// none, for an unknown wind.
std::shared_ptr<const KeptSite> SiteAt(const StoredSites& stored,
                                       const FlightMap& map,
                                       const GeoPoint& place,
                                       const std::optional<Aircraft>& aircraft,
                                       const std::optional<Eigen::Vector2d>& wind_in_world);

}  // namespace freelsd
