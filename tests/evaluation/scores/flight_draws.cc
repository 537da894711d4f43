#include "tests/evaluation/scores/flight_draws.h"

#include <cmath>

#include "engine/geometry/geometry.h"
#include "tests/synthetic/noise.h"

namespace freelsd {
namespace {

// Own normal numbers: those of <random> differ between standard libraries.
class NormalNumbers {
 public:
  explicit NormalNumbers(uint64_t seed) : seed_(seed) {}
  // Two independent numbers of deviation 1: Box and Muller 1958.
  Eigen::Vector2d Next() {
    const double u = 1.0 - Uniform(seed_, ++num_drawn_, 0.0, 1.0);
    const double angle = Uniform(seed_, ++num_drawn_, 0.0, 2.0 * kPi);
    return std::sqrt(-2.0 * std::log(u)) * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  }

 private:
  uint64_t seed_;
  uint64_t num_drawn_ = 0;
};

}  // namespace

std::vector<FlightDraw> DrawFlights(uint64_t seed, const DrawOptions& options) {
  constexpr double kSdsPerRadius = 2.0;
  std::vector<FlightDraw> draws;
  draws.reserve(static_cast<size_t>(options.num_flights));
  for (int i = 0; i < options.num_flights; ++i) {
    NormalNumbers numbers(MixSeed(seed, static_cast<uint64_t>(i)));
    Eigen::Vector2d in_sds = numbers.Next();
    while (in_sds.norm() > kSdsPerRadius) in_sds = numbers.Next();
    const Eigen::Vector2d error = in_sds * options.disc_radius_m / kSdsPerRadius;
    draws.push_back(
        {error.x(), error.y(), options.wind_in_world + options.wind_sd_mps * numbers.Next()});
  }
  return draws;
}

}  // namespace freelsd
