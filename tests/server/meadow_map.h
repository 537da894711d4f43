// The meadow as the map of a flight.
#pragma once

#include <optional>
#include <string>

#include "server/maps/maps.h"
#include "tests/server/meadow.h"

namespace freelsd {

// A map of flight "f" with these rasters, photographed by two frames, "left" and "right"; not in
// force. The frames show the western and the eastern half of the ground, 20 m wider. `photo`: the
// lattice of its picture, which has no tiles yet.
FlightMapRow StageMeadowMap(Storage& storage,
                            const SiteMap& ground,
                            const std::string& flight_id = "f",
                            int64_t seen_at_us = 1600000000000000,
                            const std::optional<PhotoLattice>& photo = std::nullopt,
                            double longitude_deg = 8.0);
// MeadowSite on the map.
SiteRow SiteOnMap(const FlightMapRow& map, double longitude_deg = 8.0);
// One tile of a picture of 1 m per pixel, in one colour: from the origin 512 m to the east and to
// the south. The map has the lattice {1.0, 512, 1}.
void PutMeadowPicture(Storage& storage, const FlightMapRow& map);
// Both in force, and nothing else of the flight.
void StoreMeadowMap(Storage& storage, const SiteMap& ground);

}  // namespace freelsd
