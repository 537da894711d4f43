// Whether two landings are one: two regions, or two flights, may hold the same field.
#pragma once

#include <optional>

#include "engine/flight/flight.h"

namespace freelsd {

struct Landing {
  GeoPoint touchdown;
  // Direction of travel on final, radians clockwise from north.
  double heading = 0.0;
  // In calm or unknown wind the heading is a choice and tells no places apart.
  bool is_heading_free = false;
};

Landing LandingOf(const GeoPoint& touchdown,
                  double heading,
                  const std::optional<Eigen::Vector2d>& wind_in_world);
// Touchdowns within 30 m, headings within 15 degrees.
bool IsSamePlace(const Landing& a, const Landing& b);

}  // namespace freelsd
