// Pictures and numbers of a flight's maps for its report.
#pragma once

#include <optional>
#include <vector>

#include "api/export/report/report.h"
#include "server/handlers/flight_picture.h"

namespace freelsd {

// All maps of the flight, newest first. Reads every tile.
std::vector<ReportedMap> ReportedMapsOf(const Service& service, const FlightPicture& picture);
// The photograph around a landing, or the hazard where there is none. Nothing if the touchdown is
// beyond all maps.
std::optional<GroundPicture> LandingPictureOf(const FlightPicture& picture, const StoredSite& site);

}  // namespace freelsd
