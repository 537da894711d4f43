// Input: a camera, its pose, and between which heights the ground lies. Output: the ground that the
// image shows.
#pragma once

#include <Eigen/Core>

#include "engine/geometry/geometry.h"

namespace freelsd {

// East-north box of the ground between two heights (world z) that the image shows; empty if
// min > max. Everything if the image shows the horizon.
struct Footprint {
  Eigen::Vector2d min_in_world, max_in_world;
};
Footprint FootprintOf(const Camera& camera,
                      const Rigid3d& world_from_camera,
                      double lowest_m,
                      double highest_m);

}  // namespace freelsd
