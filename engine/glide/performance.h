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

// Performance in turns at max_bank_deg.
Performance PerformanceOf(const Aircraft& aircraft);
// The same aircraft in wider turns. `turn_radius` must be at least performance.turn_radius. The
// sink rate in turns is smaller, because the bank is smaller.
Performance WithTurnRadius(Performance performance, double turn_radius);
// Sink rate in a turn with this acceleration towards its centre, m/s^2.
double SinkRateTurning(const StraightGlide& straight, double acceleration);

// Ground speed in a direction over ground (unit vector). Nothing if the wind is too strong to fly
// in this direction.
std::optional<double> GroundSpeed(const Eigen::Vector2d& direction,
                                  const Eigen::Vector2d& wind,
                                  double airspeed);
// Heading relative to the air with which the aircraft travels in this direction over ground.
double AirHeading(double travel_heading, const Eigen::Vector2d& wind, double airspeed);

}  // namespace freelsd
