#include "engine/glide/performance.h"

#include <cmath>

namespace freelsd {
namespace {

constexpr double kGravity = 9.81;  // m/s^2, as in approach/

double GlideSpeed(const Aircraft& aircraft) {
  return aircraft.glide_airspeed_mps.value_or(aircraft.landing_airspeed_mps);
}

}  // namespace

StraightGlide StraightGlideOf(const Aircraft& aircraft) {
  const double speed = GlideSpeed(aircraft);
  const double angle = std::atan(1.0 / aircraft.glide_ratio);
  return {speed * std::cos(angle), speed * std::sin(angle)};
}

double SinkRateTurning(const StraightGlide& straight, double acceleration) {
  // Induced drag grows with the square of the load factor. All drag counts as induced, which is the
  // worst case for a turn.
  const double lateral = acceleration / kGravity;
  return straight.sink_rate_mps * (1.0 + lateral * lateral);
}

Performance PerformanceOf(const Aircraft& aircraft) {
  const double speed = GlideSpeed(aircraft);
  const double bank = RadFromDeg(aircraft.max_bank_deg);
  Performance performance;
  performance.straight = StraightGlideOf(aircraft);
  performance.turn_radius = speed * speed / (kGravity * std::tan(bank));
  performance.turning_sink_rate =
      performance.straight.sink_rate_mps / std::pow(std::cos(bank), 2.0);
  return performance;
}

Performance WithTurnRadius(Performance performance, double turn_radius) {
  // The acceleration falls with the radius, and the extra sink with its square.
  const double narrower = performance.turn_radius / turn_radius;
  const double straight = performance.straight.sink_rate_mps;
  performance.turning_sink_rate =
      straight + (performance.turning_sink_rate - straight) * narrower * narrower;
  performance.turn_radius = turn_radius;
  return performance;
}

std::optional<double> GroundSpeed(const Eigen::Vector2d& direction,
                                  const Eigen::Vector2d& wind,
                                  double airspeed) {
  const double along = wind.dot(direction);
  const double across_squared = wind.squaredNorm() - along * along;
  const double left = airspeed * airspeed - across_squared;
  if (left <= 0.0) return std::nullopt;
  const double speed = along + std::sqrt(left);
  if (speed <= 0.0) return std::nullopt;
  return speed;
}

double AirHeading(double travel_heading, const Eigen::Vector2d& wind, double airspeed) {
  const Eigen::Vector2d direction = DirectionOf(travel_heading);
  const std::optional<double> speed = GroundSpeed(direction, wind, airspeed);
  if (!speed) return travel_heading;
  return HeadingOf(*speed * direction - wind);
}

}  // namespace freelsd
