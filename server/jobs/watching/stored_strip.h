// The stored picture of a site's strip, and its ground. Private to watching.
#pragma once

#include <memory>
#include <optional>

#include "api/stored/stored.h"
#include "engine/watch/watch.h"
#include "server/maps/maps.h"

namespace freelsd {

// A strip in the world of its map.
struct StoredStrip {
  StripPicture picture;
  LocalFrame local_frame{GeoPoint{}};
  std::string altitude_datum;
  std::string flight_id;
  // The roll's corners.
  std::vector<GeoPoint> corners;
  // Highest known ground of the roll, altitude in altitude_datum.
  double highest_m = 0.0;
};

// Nothing if the site's map has no picture, or if its plan has no roll.
std::optional<StoredStrip> StoredStripOf(const Storage& storage,
                                         FlightMaps& maps,
                                         const SiteRow& site,
                                         const WatchOptions& options);

}  // namespace freelsd
