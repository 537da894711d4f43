// Private to risk/: the errors of the flights over which a risk is averaged.
#pragma once

#include <vector>

namespace freelsd {

// All are standard normal numbers, except the touchdown.
struct FlightErrors {
  // Along and across the final, in units of the disc's radius. Normal with a deviation of half the
  // radius, cut off at the disc's edge.
  double touchdown_along = 0.0;
  double touchdown_across = 0.0;
  // The map's shift along and across the final, and its tilt along the final.
  double shift_along = 0.0;
  double shift_across = 0.0;
  double tilt = 0.0;
  double wind = 0.0;
};

// Points of a Halton sequence: the same for every landing.
std::vector<FlightErrors> MakeFlightErrors(int num_flights);

// Inverse of the standard normal distribution.
double NormalQuantile(double probability);
// Standard normal distribution.
double NormalCdf(double value);

}  // namespace freelsd
