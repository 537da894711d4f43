// Computes from an aircraft's last positions the direction in which it moves over ground.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/flight/flight.h"

namespace freelsd {

struct PassedPosition {
  GeoPoint place;
  // When the aircraft was there, and when the server received the position.
  int64_t timestamp_us = 0;
  int64_t arrived_at_us = 0;
};

// Degrees clockwise from north, in [0, 360). `passed`: the latest first.
// Needs three positions within a few seconds, roughly on a line. The first and the last must be
// much farther apart than the noise of positions. Otherwise returns nothing.
std::optional<double> CourseDeg(const std::vector<PassedPosition>& passed);

}  // namespace freelsd
