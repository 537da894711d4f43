// What views see of fields, for the tests of regions/.
#pragma once

#include <string>
#include <utility>

#include "engine/regions/region_update.h"

namespace freelsd {

// Axis-parallel rectangle about a centre.
inline Detection Rectangle(
    double east, double north, double width, double height, bool is_grass = true) {
  Detection detection;
  for (const auto& [x, y] : {std::pair(-0.5, -0.5), {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}) {
    detection.corners_in_world.emplace_back(east + x * width, north + y * height, 0.0);
  }
  detection.centroid_in_world = {east, north, 0.0};
  detection.is_fully_visible = true;
  detection.is_grass = is_grass;
  detection.area_m2 = width * height;
  return detection;
}

inline Detection PartlyVisible(Detection detection) {
  detection.is_fully_visible = false;
  return detection;
}

inline ViewStamp Stamp(size_t view) {
  return {.view = view,
          .frame_id = "frame " + std::to_string(view),
          .timestamp_us = static_cast<int64_t>(1000 * view)};
}

}  // namespace freelsd
