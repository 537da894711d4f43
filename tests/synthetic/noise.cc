#include "tests/synthetic/noise.h"

#include <cmath>
#include <random>
#include <vector>

namespace freelsd {
namespace {

constexpr uint64_t kLatticeSeed = 20;
constexpr double kTwoPi = 6.28318530717958647692;

double UnitInterval(uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1.0p-53; }

}  // namespace

uint64_t MixSeed(uint64_t seed, uint64_t purpose) {
  uint64_t z = seed + 0x9e3779b97f4a7c15ull * (purpose + 1);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return z ^ (z >> 31);
}

double Uniform(uint64_t seed, uint64_t purpose, double low, double high) {
  std::mt19937_64 random(MixSeed(seed, purpose));
  return low + (high - low) * UnitInterval(random());
}

Noise::Noise(uint64_t seed, double wavelength_m) : lattice_(SharedLattice()) {
  const double angle = kTwoPi * UnitInterval(MixSeed(seed, 1));
  cos_per_wavelength_ = std::cos(angle) / wavelength_m;
  sin_per_wavelength_ = std::sin(angle) / wavelength_m;
  // Far enough from zero that truncation is floor for every place of a world.
  shift_x_ = 4.0e6 + kLatticeSize * UnitInterval(MixSeed(seed, 2));
  shift_y_ = 4.0e6 + kLatticeSize * UnitInterval(MixSeed(seed, 3));
}

const float* Noise::SharedLattice() {
  static const std::vector<float> kLattice = [] {
    std::vector<float> values(size_t{kLatticeSize} * kLatticeSize);
    std::mt19937_64 random(kLatticeSeed);
    std::normal_distribution<float> normal;
    for (float& value : values) value = normal(random);
    return values;
  }();
  return kLattice.data();
}

}  // namespace freelsd
