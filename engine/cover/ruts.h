// Private to cover/. Pairs of ruts among green plants, cell by cell.
#pragma once

#include <vector>

#include "engine/cover/cover.h"

namespace freelsd {

// A place midway between two ruts, in cells of the orthophoto.
struct TrackPlace {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  double direction = 0.0;  // radians from a row's own, in [0, pi)
  double contrast = 0.0;
};

// One for every rut cell with a second rut beside it, in the direction of highest contrast.
// Row-major by rut cell.
std::vector<TrackPlace> RutPairs(const Orthophoto& photo, const CoverOptions& options);

}  // namespace freelsd
