// Private to approach/: where final and circle lie.
#pragma once

#include <vector>

#include "engine/approach/approach.h"

namespace freelsd {

// One wind that has to be reckoned with.
struct WindScenario {
  double approach_distance = 0.0;
  double loiter_radius = 0.0;
  double crosswind = 0.0;
};

struct HeadingCase {
  // Direction of travel, radians clockwise from north.
  double heading = 0.0;
  // All must be clear; the first is the one to fly.
  std::vector<WindScenario> scenarios;
};

struct WindCase {
  // To try; in none of them is it another wind.
  std::vector<HeadingCase> headings;
  bool is_known = false;
  bool is_too_strong = false;
  double wind_speed = 0.0;
};

// Known: into the wind. Calm: all headings. Unknown: all headings, for calm and from behind.
WindCase MakeWindCase(const std::optional<Eigen::Vector2d>& wind_in_world,
                      const Aircraft& aircraft,
                      const ApproachOptions& options);

// One way to come down; the ground it needs is that of all its headings.
struct Way {
  // Place in options.start_height_ratios.
  size_t start_height = 0;
  // Comes in from that height.
  Aircraft aircraft;
  WindCase wind;

  std::vector<WindScenario> Scenarios() const;
};

// In the order of trying: headings of the wind case, then across the wind, then both from higher
// up. Those from higher up are for where circles are blocked.
std::vector<Way> WaysDown(const std::optional<Eigen::Vector2d>& wind_in_world,
                          const Aircraft& aircraft,
                          const ApproachOptions& options);

// Start of the final, circle's centre and sizes; what needs a map is left empty.
Approach MakeApproach(const Eigen::Vector3d& touchdown_in_world,
                      double heading,
                      const WindScenario& scenario,
                      LoiterDirection direction,
                      double approach_height);

}  // namespace freelsd
