// Private to cover/. Finds pairs of ruts among green plants, for each cell separately.
#pragma once

#include <vector>

#include "engine/cover/cover.h"

namespace freelsd {

// A point midway between two ruts. `place` is (column, row) in cells of the orthophoto.
struct TrackPlace {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  double direction = 0.0;  // radians from east towards south, in [0, pi)
  double contrast = 0.0;
};

// One place for every cell in a rut that has a second rut beside it. If several directions are
// possible, the one with the highest contrast is taken. The order is that of the cells, row-major.
std::vector<TrackPlace> RutPairs(const Orthophoto& photo, const CoverOptions& options);

}  // namespace freelsd
