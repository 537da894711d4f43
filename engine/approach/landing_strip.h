// Private to approach/: the free ground around a touchdown.
#pragma once

#include <vector>

#include "engine/approach/approach.h"

namespace freelsd {

// `aircraft` must include its margins (WithPositionMargin).
LandingStrip MeasureStrip(const Eigen::Vector3d& touchdown_in_world,
                          double heading,
                          const HazardLayers& hazards,
                          const Aircraft& aircraft);

// Corners of the strip that must be free for the ground roll, at the touchdown's height. Empty if
// the aircraft needs no ground roll.
std::vector<Eigen::Vector3d> GroundRollCorners(const Eigen::Vector3d& touchdown_in_world,
                                               double heading,
                                               const Aircraft& aircraft);

}  // namespace freelsd
