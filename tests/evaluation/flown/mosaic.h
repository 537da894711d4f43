// Worlds side by side, whose truth is known everywhere between their outer edges.
#pragma once

#include <cstdint>
#include <deque>

#include "tests/evaluation/synthetic_flight.h"

namespace freelsd {

// A place and the world that it lies in, or the nearest one.
struct MosaicPlace {
  const World* world = nullptr;
  // Its frame.
  Eigen::Vector3d in_world = Eigen::Vector3d::Zero();

  // Above the highest thing there.
  double HeightAbove() const { return in_world.z() - world->TopHeight(in_world.x(), in_world.y()); }
};

class Mosaic {
 public:
  // What only photographs need is dropped.
  void Add(World world);

  const std::deque<World>& worlds() const { return worlds_; }
  // Of the first world.
  const GeoPoint& origin() const { return worlds_.front().origin; }
  MosaicPlace PlaceOf(const GeoPoint& place) const;

 private:
  std::deque<World> worlds_;
  std::deque<LocalFrame> frames_;
};

// World `i` of side x side worlds of 500 m, counted from the south-west, row by row, and the flight
// over it. Tells its number on the standard error.
Scenario MakeMosaicPart(uint64_t first_seed, int side, int i, const ScenarioOptions& options);
// All of them, without photographs.
Mosaic MakeMosaic(uint64_t first_seed, int side);

}  // namespace freelsd
