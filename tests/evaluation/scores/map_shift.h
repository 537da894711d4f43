// Input: a map and its world. Output: by how much the map lies aside, place by place.
//
// The shift is the one that brings what stands on the map onto what stands in the world. The mean
// error of the cameras is not enough: a block that is tilted or bent is shifted elsewhere on the
// ground.
#pragma once

#include <map>
#include <utility>

#include "engine/terrain/terrain.h"
#include "tests/evaluation/scores/elevation_error.h"
#include "tests/evaluation/truth_map.h"

namespace freelsd {

struct MapOffset {
  // Horizontal, of the whole map: estimate less truth, metres.
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  ErrorPlane height;
  // Horizontal shift of the squares of kTileM that have one of their own, by column and row.
  std::map<std::pair<int, int>, Eigen::Vector2d> shift_of_tile = {};

  static constexpr double kTileM = 50.0;
  Eigen::Vector2d ShiftAt(const Eigen::Vector2d& place) const;
};

// `cameras`: mean error of the cameras; the shift is searched around it.
MapOffset OffsetOfMap(const World& world,
                      const TruthMap& truth,
                      const ElevationMap& map,
                      const ErrorPlane& height,
                      const Eigen::Vector2d& cameras);

}  // namespace freelsd
