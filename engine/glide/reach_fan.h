// Private to glide/: the ground that turning once and flying straight reaches, in one wind and from
// one heading.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/glide/height_pyramid.h"
#include "engine/glide/performance.h"
#include "engine/glide/reach.h"

namespace freelsd {

// Polygons in columns and rows of the ground's grid.
using FanPolygon = std::vector<Eigen::Vector2d>;

struct FanTask {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  // Relative to the air.
  double heading = 0.0;
  Eigen::Vector2d wind = Eigen::Vector2d::Zero();
  Performance performance;
  // Of a whole turn. Each is a sector between two angles of turning.
  int num_sectors = 0;
  // Longest straight flight, metres in the frame of the air.
  double max_straight_m = 0.0;
  // A line reaches so much farther than to where the other turn is shorter, so that no gap is left
  // between the turns.
  double overlap_m = 0.0;
};

struct Fan {
  // Parts of sectors: the ground that is reached. They overlap.
  std::vector<FanPolygon> polygons;
  // Of all lines.
  int64_t num_steps = 0;
};

// Lines whose turn is longer than half a circle end where turning the other way is shorter. Near
// the aircraft they do not: the circle beside it can be reached by no other turn.
Fan FanOf(const FanTask& task,
          const Grid& grid,
          const HeightPyramid& pyramid,
          const ReachLimits& limits);

}  // namespace freelsd
