// Private to the countryside: the lots that its square is split into.
#pragma once

#include "tests/synthetic/world.h"

namespace freelsd {

// What makes a meadow a good field or a trap.
enum class Feature { kGood, kTussocks, kBoulders, kAnimals, kDitch, kBales, kParkedCars };

struct Lot {
  // In the layout's frame.
  Eigen::Vector2d min, max;
  Cover cover = Cover::kMeadow;
  Feature feature = Feature::kGood;
  uint8_t variant = 0;

  Eigen::Vector2d Size() const { return max - min; }
  Eigen::Vector2d Middle() const { return 0.5 * (min + max); }
};

// A split of the layout: lots on both sides; the first ones are lanes.
struct Split {
  int axis = 0;
  double at = 0.0;
  int lower = 0, upper = 0;  // index into splits, or ~index into lots
  bool is_lane = false;
  Eigen::Vector2d start, end;
};

}  // namespace freelsd
