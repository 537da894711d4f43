// Private to hazard/. Pairs of ruts among green plants, cell by cell.
#pragma once

#include <vector>

#include "engine/hazard/hazard.h"

namespace freelsd {

// A place midway between two ruts, in cells of the photograph.
struct TrackPlace {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  double direction = 0.0;  // radians from a row's own, in [0, pi)
  double contrast = 0.0;
};

// For every cell of a rut that has another one beside it, the direction that tells most; by row and
// column of the rut.
std::vector<TrackPlace> RutPairs(const Orthophoto& photo, const HazardOptions& options);

}  // namespace freelsd
