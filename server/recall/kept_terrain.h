// The ground of a stored map as something to fly over. Private to recall.
#pragma once

#include <optional>
#include <string>

#include "api/export/layers/layers.h"
#include "storage/storage.h"

namespace freelsd {

// The part of a site's map that is needed to check a flight over it. Its cells are blocks of the
// map's cells, about 2 m wide.
struct KeptTerrain {
  GeoPoint origin;
  Grid grid;
  // Greatest height of an object, of the ground, or of an obstacle in each block
  // (ElevationMap::upper).
  cv::Mat1f upper;
  // 1 where the whole block is seen.
  cv::Mat1b is_seen;
  // ElevationMap::position_sd_m.
  double position_sd_m = 0.0;
  // The map and all that its circles may reach.
  BoundingBox surroundings{};
  // Of all obstacles there.
  std::string obstacles_key = {};
  // Flight of the map, if its memory is "none". Empty: the map counts for everyone.
  std::string experiment_id = {};

  bool CountsFor(const std::optional<std::string>& flight_id) const {
    return experiment_id.empty() || experiment_id == flight_id;
  }
};

}  // namespace freelsd
