#include "engine/risk/flight_errors.h"

#include <array>
#include <cmath>

#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

// Radical inverse of `index` (Halton 1960): its digits in the base, mirrored at the point.
double RadicalInverse(int index, int base) {
  double share = 1.0, value = 0.0;
  for (int rest = index; rest > 0; rest /= base) {
    share /= base;
    value += share * (rest % base);
  }
  return value;
}

// Standard deviations of the touchdown from its middle to the disc's edge.
constexpr double kSdsPerRadius = 2.0;

}  // namespace

double NormalCdf(double value) { return 0.5 * std::erfc(-value * std::sqrt(0.5)); }

double NormalQuantile(double probability) {
  // Bisection: called a few hundred times a map, and exact to the last bits.
  constexpr double kLargest = 9.0;
  constexpr int kNumHalvings = 60;
  double low = -kLargest, high = kLargest;
  for (int i = 0; i < kNumHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (NormalCdf(middle) < probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

std::vector<FlightErrors> MakeFlightErrors(int num_flights) {
  constexpr std::array<int, 6> kBases{2, 3, 5, 7, 11, 13};
  // Share of a normal distribution in the plane that lies on the disc.
  const double on_disc = 1.0 - std::exp(-0.5 * kSdsPerRadius * kSdsPerRadius);
  std::vector<FlightErrors> flights;
  flights.reserve(static_cast<size_t>(num_flights));
  for (int i = 1; i <= num_flights; ++i) {
    // Rayleigh distribution of the distance, cut off at the edge.
    const double distance =
        std::sqrt(-2.0 * std::log(1.0 - on_disc * RadicalInverse(i, kBases[0]))) / kSdsPerRadius;
    const double direction = 2.0 * kPi * RadicalInverse(i, kBases[1]);
    flights.push_back({.touchdown_along = distance * std::cos(direction),
                       .touchdown_across = distance * std::sin(direction),
                       .shift_along = NormalQuantile(RadicalInverse(i, kBases[2])),
                       .shift_across = NormalQuantile(RadicalInverse(i, kBases[3])),
                       .tilt = NormalQuantile(RadicalInverse(i, kBases[4])),
                       .wind = NormalQuantile(RadicalInverse(i, kBases[5]))});
  }
  return flights;
}

}  // namespace freelsd
