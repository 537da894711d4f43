// Private to the countryside: the lots that its square is split into.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "tests/synthetic/world.h"

namespace freelsd {

// The same numbers for the same seed, on every machine.
class Random {
 public:
  explicit Random(uint64_t seed) : engine_(seed) {}
  double Uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1.0p-53;
  }

 private:
  std::mt19937_64 engine_;
};

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
  // Of the four sides, the place nearest to one within.
  Eigen::Vector2d NearestOnBorder(const Eigen::Vector2d& place) const;
};

// A split of the layout: lots on both sides; the first ones are lanes.
struct Split {
  int axis = 0;
  double at = 0.0;
  int lower = 0, upper = 0;  // index into splits, or ~index into lots
  bool is_lane = false;
  Eigen::Vector2d start, end;
};

// A rectangle that is split again and again.
class LotLayout {
 public:
  LotLayout() = default;
  LotLayout(const Eigen::Vector2d& min, const Eigen::Vector2d& max, Random& random);

  const std::vector<Lot>& lots() const { return lots_; }
  const std::vector<Split>& splits() const { return splits_; }
  const Lot& LotAt(const Eigen::Vector2d& place) const;
  // Distance to the middle of the nearest lane.
  double ToLane(const Eigen::Vector2d& place) const;

 private:
  int Divide(const Eigen::Vector2d& min, const Eigen::Vector2d& max, int depth, Random& random);
  int AddLot(const Eigen::Vector2d& min, const Eigen::Vector2d& max, Random& random);

  std::vector<Lot> lots_;
  std::vector<Split> splits_;
  int root_ = 0;
};

}  // namespace freelsd
