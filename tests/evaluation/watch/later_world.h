// A piece of a world at a later time: other light and weather, and new things.
#pragma once

#include <vector>

#include "tests/evaluation/watch/second_pass.h"
#include "tests/synthetic/world.h"

namespace freelsd {

// A piece of a world, and where its middle lies in that world.
struct WorldPiece {
  World world;
  Eigen::Vector2d middle_in_world = Eigen::Vector2d::Zero();
};
WorldPiece PieceOf(const World& world, const Eigen::Vector2d& low, const Eigen::Vector2d& high);

// Sun, clouds, wet grass, growth.
void ChangeScene(SceneChange change, uint64_t seed, World& world);

// Clouds that the wind moves: darkens the light under them. For SceneChange::kCloudShadows.
void ShadeByClouds(uint64_t seed, double seconds, World& world);

// A thing with the colours of its parts along its length, BGR.
struct ColoredBlock {
  Block block;
  std::vector<cv::Vec3b> colors;
};
// To be lit afterwards.
void PutColored(const ColoredBlock& thing, World& world);

// Where the things of an event are at a time; time 0 is the middle of the pass. `axis`: unit vector
// along the strip, `half_length`, `half_width` of it.
struct StripShape {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  double heading = 0.0;
  double half_length_m = 20.0;
  double half_width_m = 5.0;
};
std::vector<ColoredBlock> ThingsAt(WatchEvent event,
                                   const StripShape& strip,
                                   uint64_t seed,
                                   double seconds);

}  // namespace freelsd
