// The geometry of final and loiter-down circle. Paper: Eq. 1.
#pragma once

#include <vector>

#include "engine/approach/approach.h"

namespace freelsd {

// One way to come in: where it lands, from which side, in which wind.
struct Leg {
  Eigen::Vector3d touchdown_in_world = Eigen::Vector3d::Zero();
  // Direction of travel, radians clockwise from north.
  double heading = 0.0;
  double wind_speed = 0.0;
};

// Start, length and radius of the leg; nothing where the wind is too strong for a final.
std::optional<Approach> ApproachOf(const Leg& leg, const Aircraft& aircraft);

// Centre of the circle that touches the final at its start and is left along it.
Eigen::Vector3d LoiterCenter(const Approach& approach, LoiterDirection direction);

// Headings worth trying: into the wind, or all of them when it is calm or unknown.
std::vector<double> HeadingsFor(const std::optional<Eigen::Vector2d>& wind_in_world,
                                const ApproachOptions& options);

}  // namespace freelsd
