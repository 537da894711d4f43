#include "tests/synthetic/noise.h"

#include <cmath>
#include <random>

namespace freelsd {
namespace {

constexpr int kLatticeSize = 512;  // a power of two: the lattice repeats after so many wavelengths
constexpr int kLatticeMask = kLatticeSize - 1;
// Smooth interpolation averages neighbours; this brings the standard deviation back to 1.
constexpr float kInterpolationGain = 1.36f;
constexpr uint64_t kLatticeSeed = 20;
constexpr double kTwoPi = 6.28318530717958647692;

// One lattice serves all octaves; each reads it at its own turn and shift.
std::shared_ptr<const std::vector<float>> SharedLattice() {
  static const std::shared_ptr<const std::vector<float>> lattice = [] {
    auto values = std::make_shared<std::vector<float>>(kLatticeSize * kLatticeSize);
    std::mt19937_64 random(kLatticeSeed);
    std::normal_distribution<float> normal;
    for (float& value : *values) value = normal(random);
    return values;
  }();
  return lattice;
}

double UnitInterval(uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1.0p-53; }

float Smooth(float t) { return t * t * (3.0f - 2.0f * t); }

}  // namespace

uint64_t MixSeed(uint64_t seed, uint64_t purpose) {
  uint64_t z = seed + 0x9e3779b97f4a7c15ull * (purpose + 1);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return z ^ (z >> 31);
}

Noise::Noise(uint64_t seed, double wavelength_m) : lattice_(SharedLattice()) {
  const double angle = kTwoPi * UnitInterval(MixSeed(seed, 1));
  cos_per_wavelength_ = std::cos(angle) / wavelength_m;
  sin_per_wavelength_ = std::sin(angle) / wavelength_m;
  // Far enough from zero that truncation is floor for every place of a world.
  shift_x_ = 4.0e6 + kLatticeSize * UnitInterval(MixSeed(seed, 2));
  shift_y_ = 4.0e6 + kLatticeSize * UnitInterval(MixSeed(seed, 3));
}

float Noise::At(double x, double y) const {
  const double u = x * cos_per_wavelength_ - y * sin_per_wavelength_ + shift_x_;
  const double v = x * sin_per_wavelength_ + y * cos_per_wavelength_ + shift_y_;
  const int col = static_cast<int>(u);
  const int row = static_cast<int>(v);
  const float tu = Smooth(static_cast<float>(u - col));
  const float tv = Smooth(static_cast<float>(v - row));
  const float* upper = lattice_->data() + (row & kLatticeMask) * kLatticeSize;
  const float* lower = lattice_->data() + ((row + 1) & kLatticeMask) * kLatticeSize;
  const int left = col & kLatticeMask;
  const int right = (col + 1) & kLatticeMask;
  const float top = upper[left] + tu * (upper[right] - upper[left]);
  const float bottom = lower[left] + tu * (lower[right] - lower[left]);
  return kInterpolationGain * (top + tv * (bottom - top));
}

}  // namespace freelsd
