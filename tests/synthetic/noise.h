// Input: a seed. Output: smooth random functions of the plane, the same on every run.
#pragma once

#include <cstddef>
#include <cstdint>

namespace freelsd {

// One octave of value noise: mean 0, standard deviation about 1, features about `wavelength_m`
// across. The lattice is turned and shifted by the seed, so that octaves do not line up.
class Noise {
 public:
  Noise(uint64_t seed, double wavelength_m);
  float At(double x, double y) const {
    const double u = x * cos_per_wavelength_ - y * sin_per_wavelength_ + shift_x_;
    const double v = x * sin_per_wavelength_ + y * cos_per_wavelength_ + shift_y_;
    const int col = static_cast<int>(u);
    const int row = static_cast<int>(v);
    const float tu = Smooth(static_cast<float>(u - col));
    const float tv = Smooth(static_cast<float>(v - row));
    const float* upper = lattice_ + std::ptrdiff_t{row & kLatticeMask} * kLatticeSize;
    const float* lower = lattice_ + std::ptrdiff_t{(row + 1) & kLatticeMask} * kLatticeSize;
    const int left = col & kLatticeMask;
    const int right = (col + 1) & kLatticeMask;
    const float top = upper[left] + tu * (upper[right] - upper[left]);
    const float bottom = lower[left] + tu * (lower[right] - lower[left]);
    return kInterpolationGain * (top + tv * (bottom - top));
  }

 private:
  // A power of two: the lattice repeats after so many wavelengths.
  static constexpr int kLatticeSize = 512;
  static constexpr int kLatticeMask = kLatticeSize - 1;
  // Smooth interpolation averages neighbours; this brings the standard deviation back to 1.
  static constexpr float kInterpolationGain = 1.36f;

  static float Smooth(float t) { return t * t * (3.0f - 2.0f * t); }
  // One lattice serves all octaves; each reads it at its own turn and shift.
  static const float* SharedLattice();

  const float* lattice_;
  double cos_per_wavelength_ = 0.0;
  double sin_per_wavelength_ = 0.0;
  double shift_x_ = 0.0;
  double shift_y_ = 0.0;
};

// A different seed for every purpose, from one seed: SplitMix64.
uint64_t MixSeed(uint64_t seed, uint64_t purpose);
// One number for every seed and purpose.
double Uniform(uint64_t seed, uint64_t purpose, double low, double high);

}  // namespace freelsd
