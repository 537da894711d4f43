#include "tests/synthetic/countryside_lots.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace freelsd {
namespace {

constexpr double kMinSideM = 34.0;
constexpr double kMaxSideM = 150.0;  // less is split no more, with a probability

}  // namespace

Eigen::Vector2d Lot::NearestOnBorder(const Eigen::Vector2d& place) const {
  Eigen::Vector2d nearest = place;
  double least = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 2; ++axis) {
    for (const double side : {min[axis], max[axis]}) {
      const double distance = std::abs(place[axis] - side);
      if (distance >= least) continue;
      least = distance;
      nearest = place;
      nearest[axis] = side;
    }
  }
  return nearest;
}

LotLayout::LotLayout(const Eigen::Vector2d& min, const Eigen::Vector2d& max, Random& random) {
  root_ = Divide(min, max, 0, random);
}

// Node of the tree of splits over a rectangle: an index, or ~index of a lot.
int LotLayout::Divide(const Eigen::Vector2d& min,
                      const Eigen::Vector2d& max,
                      int depth,
                      Random& random) {
  const Eigen::Vector2d size = max - min;
  const int axis = size.x() >= size.y() ? 0 : 1;
  const bool may_stay = size.maxCoeff() < kMaxSideM && random.Uniform(0, 1) < 0.55;
  if (size[axis] < 2.0 * kMinSideM || may_stay) return ~AddLot(min, max, random);
  const size_t index = splits_.size();
  splits_.emplace_back();
  Split split;
  split.axis = axis;
  split.at = min[axis] + size[axis] * random.Uniform(0.35, 0.65);
  split.is_lane = depth == 1 && random.Uniform(0, 1) < 0.7;
  split.start = min;
  split.end = max;
  split.start[axis] = split.end[axis] = split.at;
  Eigen::Vector2d middle_max = max, middle_min = min;
  middle_max[axis] = middle_min[axis] = split.at;
  split.lower = Divide(min, middle_max, depth + 1, random);
  split.upper = Divide(middle_min, max, depth + 1, random);
  splits_[index] = split;
  return static_cast<int>(index);
}

int LotLayout::AddLot(const Eigen::Vector2d& min, const Eigen::Vector2d& max, Random& random) {
  Lot lot{min, max};
  struct Share {
    Cover cover;
    double share;
  };
  constexpr Share kShares[] = {{Cover::kMeadow, 0.42},
                               {Cover::kCrop, 0.12},
                               {Cover::kStubble, 0.12},
                               {Cover::kSoil, 0.08},
                               {Cover::kScrub, 0.08},
                               {Cover::kWater, 0.04},
                               {Cover::kGravel, 0.04}};
  lot.cover = Cover::kTree;  // the rest
  double dice = random.Uniform(0, 1);
  for (const Share& share : kShares) {
    if (dice >= 0.0 && dice < share.share) lot.cover = share.cover;
    dice -= share.share;
  }
  constexpr Feature kTraps[] = {Feature::kTussocks,
                                Feature::kBoulders,
                                Feature::kAnimals,
                                Feature::kDitch,
                                Feature::kBales,
                                Feature::kParkedCars};
  const double trap = random.Uniform(0, 1);
  if (trap < 0.42) lot.feature = kTraps[static_cast<int>(trap / 0.07)];
  lot.variant = static_cast<uint8_t>(random.Uniform(0.0, 255.9));
  lots_.push_back(lot);
  return static_cast<int>(lots_.size()) - 1;
}

const Lot& LotLayout::LotAt(const Eigen::Vector2d& place) const {
  int node = root_;
  while (node >= 0) {
    const Split& split = splits_[static_cast<size_t>(node)];
    node = place[split.axis] < split.at ? split.lower : split.upper;
  }
  const int lot = ~node;
  return lots_[static_cast<size_t>(lot)];
}

double LotLayout::ToLane(const Eigen::Vector2d& place) const {
  double nearest = 1e9;
  for (const Split& split : splits_) {
    if (!split.is_lane) continue;
    const int other = 1 - split.axis;
    if (place[other] < split.start[other] || place[other] > split.end[other]) continue;
    nearest = std::min(nearest, std::abs(place[split.axis] - split.at));
  }
  return nearest;
}

}  // namespace freelsd
