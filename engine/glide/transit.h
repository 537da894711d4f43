// Private to glide/: turns and straight glide from the aircraft to the start of a final, in wind.
#pragma once

#include <optional>
#include <vector>

#include "engine/glide/performance.h"
#include "engine/glide/shortest_turns.h"

namespace freelsd {

// The widest turns that are tried, in radii of the tightest.
inline constexpr double kMaxRadiusRatio = 6.0;

// Tracks over ground: the known one, or evenly spaced ones.
std::vector<double> HeadingsToReckonWith(const GlideStart& start, const GlideOptions& options);

// The known wind, itself and turned by the aircraft's uncertainty; or calm and unknown winds.
std::vector<Eigen::Vector2d> WindsToReckonWith(const GlideStart& start,
                                               const Aircraft& aircraft,
                                               const GlideOptions& options);

// Time margin for headings between the tried ones: at most this turn, there and back. 0 for a known
// heading.
double TimeBetweenHeadings(const GlideStart& start,
                           const Performance& performance,
                           const GlideOptions& options);

// Headings are relative to the air. At time 0 the frame of the moving air is the ground's.
struct TransitTask {
  Stance from;
  Stance to;
  Eigen::Vector2d wind;
};

// From headings over ground.
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

// With the performance's turn radius. Nothing if no path is found: the wind is too strong, or the
// shortest path changes its kind at the time of arrival.
std::optional<Transit> TransitOf(const TransitTask& task, const Performance& performance);

// Time and height lost where no path is found, at most: any time that is long enough works, because
// surplus time is spent in turns. Its path is empty. Nothing if the wind is too strong.
std::optional<Transit> LongestTransit(const TransitTask& task, const Performance& performance);

// With the tightest turns for which a path is found.
std::optional<Transit> TightestTransit(const TransitTask& task, const Performance& tightest);

}  // namespace freelsd
