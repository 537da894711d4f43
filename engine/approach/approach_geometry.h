// Private to approach/: geometry of the final approach and of the loiter circle before it.
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
  // The path must be clear in each scenario. The path of the first one is flown.
  std::vector<WindScenario> scenarios;
};

struct WindCase {
  // Headings to try, all for the same wind.
  std::vector<HeadingCase> headings;
  bool is_known = false;
  bool is_too_strong = false;
  // Strongest wind speed that is allowed for, m/s: the wind plus wind_margin.
  double wind_speed = 0.0;
  // Ground speed straight into a wind of wind_speed, m/s. Negative if the aircraft would fly
  // backwards.
  double ground_speed = 0.0;
};

// Headings by wind:
// - known wind: into the wind;
// - calm: all headings;
// - unknown wind: all headings, each with a scenario in calm and one with tail wind.
// `wind_margin`, m/s: a known wind may be weaker or stronger than estimated by this value.
WindCase MakeWindCase(const std::optional<Eigen::Vector2d>& wind_in_world,
                      const Aircraft& aircraft,
                      const ApproachOptions& options,
                      double wind_margin = 0.0);

// One start height with the headings of one wind case.
struct Way {
  // Index in options.start_height_ratios.
  size_t start_height = 0;
  // The aircraft, with approach_height_m multiplied by the ratio at that index.
  Aircraft aircraft;
  WindCase wind;

  std::vector<WindScenario> Scenarios() const;
};

// Ways in the order in which they are tried: headings of the wind case, headings with crosswind,
// then both from greater start heights. A higher circle may clear obstacles that block a lower one.
std::vector<Way> WaysDown(const std::optional<Eigen::Vector2d>& wind_in_world,
                          const Aircraft& aircraft,
                          const ApproachOptions& options,
                          double wind_margin = 0.0);

// Height gained for each metre over ground by the aircraft's climb along the landing heading. If
// the final's length allows for a tail wind, this tail wind flattens the climb. A headwind does not
// count, because it may drop.
double ClimbSlope(const Approach& approach, const Aircraft& aircraft);

// Fills the start of the final, the circle, and the values of the scenario. Fields that need a map
// stay empty.
Approach MakeApproach(const Eigen::Vector3d& touchdown_in_world,
                      double heading,
                      const WindScenario& scenario,
                      LoiterDirection direction,
                      double approach_height);

}  // namespace freelsd
