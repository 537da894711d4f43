// Private to the countryside: how high its ground lies, and what grows on it.
#pragma once

#include "tests/synthetic/noise.h"
#include "tests/synthetic/world.h"

namespace freelsd {

class CountrysideRelief {
 public:
  explicit CountrysideRelief(const WorldOptions& options);

  // One hill, whose flanks are too steep to land on.
  void PlaceHill(const Eigen::Vector2d& top) { hill_ = top; }
  // World z of the bare ground.
  double GroundAt(double x, double y) const;
  // Metres that a cover stands over the ground; crops of a higher variant stand taller.
  double GrowthAt(Cover cover, uint8_t variant, double x, double y) const;
  double TussocksAt(double x, double y) const;

 private:
  double relief_sd_m_;
  Noise hills_, rolls_, swells_, tufts_, clods_, bushes_, tussocks_;
  Eigen::Vector2d hill_ = Eigen::Vector2d::Zero();
};

}  // namespace freelsd
