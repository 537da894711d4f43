// Private to approach/: the ground that an aircraft has on both sides of its touchdown.
#pragma once

#include <vector>

#include "engine/approach/approach.h"

namespace freelsd {

// `aircraft` with its margins (WithPositionMargin).
LandingStrip MeasureStrip(const Eigen::Vector3d& touchdown_in_world,
                          double heading,
                          const HazardLayers& hazards,
                          const Aircraft& aircraft);

// The corners of the strip that the ground roll needs free, at the touchdown's height. Empty
// without a ground roll.
std::vector<Eigen::Vector3d> GroundRollCorners(const Eigen::Vector3d& touchdown_in_world,
                                               double heading,
                                               const Aircraft& aircraft);

}  // namespace freelsd
