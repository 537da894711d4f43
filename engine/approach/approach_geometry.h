// Private to approach/: positions and sizes of final and circle.
#pragma once

#include <optional>
#include <vector>

#include "engine/approach/approach.h"

namespace freelsd {

// One wind that the path must be safe in.
struct WindScenario {
  double approach_distance = 0.0;
  double loiter_radius = 0.0;
  double crosswind = 0.0;
  // Ground speed on final, m/s. Empty: the wind is unknown.
  std::optional<double> ground_speed = std::nullopt;
};

struct HeadingCase {
  // Direction of travel, radians clockwise from north.
  double heading = 0.0;
  // All must be clear; the first is the one to fly.
  std::vector<WindScenario> scenarios;
};

struct WindCase {
  // Headings to try, all for the same wind.
  std::vector<HeadingCase> headings;
  bool is_known = false;
  bool is_too_strong = false;
  // The strongest that is allowed for.
  double wind_speed = 0.0;
  // Straight into that wind, m/s; negative where the aircraft would fly backwards.
  double ground_speed = 0.0;
};

// Known: into the wind. Calm: all headings. Unknown: all headings, in calm and with tail wind.
// `wind_margin`, m/s: how much weaker or stronger than estimated a known wind may be.
WindCase MakeWindCase(const std::optional<Eigen::Vector2d>& wind_in_world,
                      const Aircraft& aircraft,
                      const ApproachOptions& options,
                      double wind_margin = 0.0);

// One way to come down. It needs the ground below all of its headings.
struct Way {
  // Index in options.start_height_ratios.
  size_t start_height = 0;
  // With the approach height of this start.
  Aircraft aircraft;
  WindCase wind;

  std::vector<WindScenario> Scenarios() const;
};

// In the order of trying: headings of the wind case, crosswind, then both from higher starts, which
// help where circles are blocked.
std::vector<Way> WaysDown(const std::optional<Eigen::Vector2d>& wind_in_world,
                          const Aircraft& aircraft,
                          const ApproachOptions& options,
                          double wind_margin = 0.0);

// Fills the start of the final, the circle's centre and sizes; fields that need a map stay empty.
Approach MakeApproach(const Eigen::Vector3d& touchdown_in_world,
                      double heading,
                      const WindScenario& scenario,
                      LoiterDirection direction,
                      double approach_height);

}  // namespace freelsd
