// Private to glide/: turns and straight glide from the aircraft to the start of a final, in wind.
#pragma once

#include <optional>
#include <vector>

#include "engine/glide/performance.h"
#include "engine/glide/shortest_turns.h"

namespace freelsd {

// Largest turn radius that is tried, as a multiple of the smallest turn radius.
inline constexpr double kMaxRadiusRatio = 6.0;

// Directions of travel over ground to compute with: the known one, or evenly spaced ones if it is
// unknown.
std::vector<double> HeadingsToReckonWith(const GlideStart& start, const GlideOptions& options);

// The known wind, itself, turned by the aircraft's uncertainty, and changed by its deviation; or
// calm and unknown winds.
std::vector<Eigen::Vector2d> WindsToReckonWith(const GlideStart& start,
                                               const Aircraft& aircraft,
                                               const GlideOptions& options);

// Time margin for headings between the tried ones: at most this turn, there and back. 0 for a known
// heading.
double TimeBetweenHeadings(const GlideStart& start,
                           const Performance& performance,
                           const GlideOptions& options);

// Start and end of a path through the moving air. Headings are relative to the air. At time 0, the
// frame of the moving air coincides with the frame of the ground.
struct TransitTask {
  Stance from;
  Stance to;
  Eigen::Vector2d wind;
};

// `from_heading` and `to_heading` are directions of travel over ground.
TransitTask TransitTaskOf(const Eigen::Vector2d& from,
                          double from_heading,
                          const Eigen::Vector2d& to,
                          double to_heading,
                          const Eigen::Vector2d& wind,
                          const Performance& performance);

struct Transit {
  // In the frame of the moving air.
  TurnPath path;
  Performance performance;
  double time = 0.0;
  double height_lost = 0.0;
};

// The shortest path with performance.turn_radius. Nothing if no path is found: the wind is too
// strong, or the shortest path changes its kind at the time of arrival.
std::optional<Transit> TransitOf(const TransitTask& task, const Performance& performance);

// Upper bound of time and height lost, for the case that no path is found. The aircraft can spend
// surplus time in turns, so any time that is long enough for the shortest path is possible. The
// path of the result is empty. Nothing if the wind is too strong.
std::optional<Transit> LongestTransit(const TransitTask& task, const Performance& performance);

// The shortest path with the smallest turn radius for which a path is found.
std::optional<Transit> TightestTransit(const TransitTask& task, const Performance& tightest);

}  // namespace freelsd
