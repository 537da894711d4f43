// Private to glide/: how an aircraft without power flies in the frame of the moving air.
#pragma once

#include <optional>

#include "engine/glide/glide.h"

namespace freelsd {

struct Performance {
  StraightGlide straight;
  double turn_radius = 0.0;
  double turning_sink_rate = 0.0;

  double Airspeed() const { return straight.airspeed_mps; }
};

// At the aircraft's greatest bank.
Performance PerformanceOf(const Aircraft& aircraft);
// With wider turns: at least turn_radius. Less bank sinks less.
Performance WithTurnRadius(Performance performance, double turn_radius);
// Sink rate in a turn with this acceleration towards its centre, m/s^2.
double SinkRateTurning(const StraightGlide& straight, double acceleration);

// Ground speed along a unit vector over ground; nothing if the wind is too strong to hold it.
std::optional<double> GroundSpeed(const Eigen::Vector2d& direction,
                                  const Eigen::Vector2d& wind,
                                  double airspeed);
// Heading relative to the air that gives this direction of travel over ground.
double AirHeading(double travel_heading, const Eigen::Vector2d& wind, double airspeed);

}  // namespace freelsd
