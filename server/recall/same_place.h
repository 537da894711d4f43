// Decides whether two landings are at the same place: several regions, or several flights, may
// contain the same field.
#pragma once

#include <optional>

#include "engine/flight/flight.h"

namespace freelsd {

struct Landing {
  GeoPoint touchdown;
  // Direction of travel on the final approach, radians clockwise from north.
  double heading = 0.0;
  // True in calm or unknown wind. The heading is then arbitrary and is not compared.
  bool is_heading_free = false;
};

Landing LandingOf(const GeoPoint& touchdown,
                  double heading,
                  const std::optional<Eigen::Vector2d>& wind_in_world);
// True if the touchdowns are within 30 m, and the headings within 15 degrees unless one of them is
// free.
bool IsSamePlace(const Landing& a, const Landing& b);

}  // namespace freelsd
