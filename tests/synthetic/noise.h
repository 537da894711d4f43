// Input: a seed. Output: smooth random functions of the plane, the same on every run.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

namespace freelsd {

// One octave of value noise: mean 0, standard deviation about 1, features about `wavelength_m`
// across. The lattice is turned and shifted by the seed, so that octaves do not line up.
class Noise {
 public:
  Noise(uint64_t seed, double wavelength_m);
  float At(double x, double y) const;

 private:
  std::shared_ptr<const std::vector<float>> lattice_;
  double cos_per_wavelength_ = 0.0;
  double sin_per_wavelength_ = 0.0;
  double shift_x_ = 0.0;
  double shift_y_ = 0.0;
};

// A different seed for every purpose, from one seed: SplitMix64.
uint64_t MixSeed(uint64_t seed, uint64_t purpose);

}  // namespace freelsd
