// Private to approach/: where final and circle lie.
#pragma once

#include <vector>

#include "engine/approach/approach.h"

namespace freelsd {

// One wind that has to be reckoned with.
struct WindScenario {
  double approach_distance = 0.0;
  double loiter_radius = 0.0;
};

struct WindCase {
  // Directions of travel to try, radians clockwise from north.
  std::vector<double> headings;
  // All must be clear; the first is the one to fly.
  std::vector<WindScenario> scenarios;
  bool is_known = false;
  bool is_too_strong = false;
  double wind_speed = 0.0;
};

// The same aircraft, but coming in from higher up.
Aircraft WithStartHeight(Aircraft aircraft, double ratio);

// Known: into the wind. Calm: all headings. Unknown: all headings, for calm and from behind.
WindCase MakeWindCase(const std::optional<Eigen::Vector2d>& wind_in_world,
                      const Aircraft& aircraft,
                      const ApproachOptions& options);

// One that blows towards a direction, flown against whatever its speed.
WindCase AgainstWind(const Eigen::Vector2d& towards, double wind_speed, const Aircraft& aircraft);

// Start of the final, circle's centre and sizes; what needs a map is left empty.
Approach MakeApproach(const Eigen::Vector3d& touchdown_in_world,
                      double heading,
                      const WindScenario& scenario,
                      LoiterDirection direction,
                      double approach_height);

}  // namespace freelsd
