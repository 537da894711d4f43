// Input: a seed, the aircraft's touchdown disc, the wind. Output: by how much each flight of a
// series misses its plan.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace freelsd {

struct FlightDraw {
  // Touchdown beyond the planned one, along the landing direction and to the left of it; metres.
  // Both are within the disc.
  double along = 0.0;
  double across = 0.0;
  Eigen::Vector2d wind_in_world = Eigen::Vector2d::Zero();
};

struct DrawOptions {
  int num_flights = 200;
  // The touchdown is normal with half of this deviation per axis, cut off at the disc's edge.
  double disc_radius_m = 0.0;
  Eigen::Vector2d wind_in_world = Eigen::Vector2d::Zero();
  // Per axis: gusts, and the error of the wind that the plan is made for.
  double wind_sd_mps = 0.0;
};

// Depends on seed and options alone.
std::vector<FlightDraw> DrawFlights(uint64_t seed, const DrawOptions& options);

}  // namespace freelsd
