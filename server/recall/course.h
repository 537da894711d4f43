// The direction in which an aircraft moves over ground, from the positions that it passed.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/flight/flight.h"

namespace freelsd {

struct PassedPosition {
  GeoPoint place;
  // The position's own time, and when the server received it.
  int64_t timestamp_us = 0;
  int64_t arrived_at_us = 0;
};

// Degrees clockwise from north, in [0, 360). `passed`: in the order of arrival, the latest first.
// Nothing unless three positions within a few seconds agree, and the way between them is long
// against the noise of positions.
std::optional<double> CourseDeg(const std::vector<PassedPosition>& passed);

}  // namespace freelsd
