#include "engine/glide/transit.h"

#include <algorithm>
#include <cmath>

namespace freelsd {
namespace {

// Longest glide in seconds: no small plane has enough height for more.
constexpr double kMaxTime = 3600.0;
constexpr int kMaxIterations = 60;
constexpr double kTimeTolerance = 0.01;
constexpr double kRadiusStep = 0.05;
constexpr double kTimeStep = 1.0;

double TimeOf(const TurnPath& path, const Performance& performance) {
  return (path.Turned() * performance.turn_radius + path.straight_m) / performance.Airspeed();
}

// The edge of all winds whose speed differs from that of `wind` by at most `difference_mps`, and
// whose direction by at most `turn`. They contain the circle of that radius around the wind. With a
// difference also the wind itself.
std::vector<Eigen::Vector2d> WindsAround(const Eigen::Vector2d& wind,
                                         double difference_mps,
                                         double turn,
                                         const GlideOptions& options) {
  const double speed = wind.norm(), slowest = speed - difference_mps;
  if (speed + difference_mps <= 0.0) return {wind};
  const Eigen::Vector2d along = speed > 0.0 ? Eigen::Vector2d(wind / speed) : DirectionOf(0.0);
  const double half = slowest <= 0.0 ? kPi : std::max(turn, std::asin(difference_mps / speed));
  constexpr double kRoundingError = 1e-9;
  const double num_between = half * options.num_unknown_winds / (2.0 * kPi) - kRoundingError;
  const int num_turns = std::max(1, static_cast<int>(std::ceil(num_between)));
  std::vector<Eigen::Vector2d> winds;
  if (difference_mps > 0.0) winds.push_back(wind);
  if (slowest <= 0.0 && speed > 0.0) winds.push_back(Eigen::Vector2d::Zero());
  for (int i = half < kPi ? -num_turns : 1 - num_turns; i <= num_turns; ++i) {
    const Eigen::Vector2d direction = Eigen::Rotation2Dd(half * i / num_turns) * along;
    winds.push_back((speed + difference_mps) * direction);
    if (slowest > 0.0 && difference_mps > 0.0) winds.push_back(slowest * direction);
  }
  return winds;
}

}  // namespace

std::vector<double> HeadingsToReckonWith(const GlideStart& start, const GlideOptions& options) {
  if (start.heading) return {*start.heading};
  std::vector<double> headings;
  headings.reserve(static_cast<size_t>(options.num_unknown_headings));
  for (int i = 0; i < options.num_unknown_headings; ++i) {
    headings.push_back(2.0 * kPi * i / options.num_unknown_headings);
  }
  return headings;
}

std::vector<Eigen::Vector2d> WindsToReckonWith(const GlideStart& start,
                                               const Aircraft& aircraft,
                                               const GlideOptions& options) {
  if (!start.wind_in_world) {
    return WindsAround(Eigen::Vector2d::Zero(), options.unknown_wind_mps, kPi, options);
  }
  const double turn = std::max(RadFromDeg(aircraft.crosswind_uncertainty_deg), start.wind_turn);
  return WindsAround(
      *start.wind_in_world, options.num_wind_deviations * start.wind_sd_mps, turn, options);
}

double TimeBetweenHeadings(const GlideStart& start,
                           const Performance& performance,
                           const GlideOptions& options) {
  const double turn = start.heading ? 0.0 : 2.0 * kPi / options.num_unknown_headings;
  return turn * performance.turn_radius / performance.Airspeed();
}

TransitTask TransitTaskOf(const Eigen::Vector2d& from,
                          double from_heading,
                          const Eigen::Vector2d& to,
                          double to_heading,
                          const Eigen::Vector2d& wind,
                          const Performance& performance) {
  const double airspeed = performance.Airspeed();
  return {{from, AirHeading(from_heading, wind, airspeed)},
          {to, AirHeading(to_heading, wind, airspeed)},
          wind};
}

std::optional<Transit> TransitOf(const TransitTask& task, const Performance& performance) {
  // In the frame of the moving air, the destination moves against the wind. Its place depends on
  // the time of flight.
  double time = 0.0;
  for (int i = 0; i < kMaxIterations && time < kMaxTime; ++i) {
    const Stance to{task.to.place - task.wind * time, task.to.heading};
    const TurnPath path = ShortestTurns(task.from, to, performance.turn_radius);
    const double next = TimeOf(path, performance);
    if (std::abs(next - time) < kTimeTolerance) {
      const double turning = path.Turned() * performance.turn_radius / performance.Airspeed();
      const double height_lost = turning * performance.turning_sink_rate +
                                 (next - turning) * performance.straight.sink_rate_mps;
      return Transit{path, performance, next, height_lost};
    }
    time = next;
  }
  return std::nullopt;
}

std::optional<Transit> LongestTransit(const TransitTask& task, const Performance& performance) {
  for (double time = 0.0; time < kMaxTime; time += kTimeStep) {
    const Stance to{task.to.place - task.wind * time, task.to.heading};
    const TurnPath path = ShortestTurns(task.from, to, performance.turn_radius);
    if (TimeOf(path, performance) <= time) {
      return Transit{{}, performance, time, time * performance.turning_sink_rate};
    }
  }
  return std::nullopt;
}

std::optional<Transit> TightestTransit(const TransitTask& task, const Performance& tightest) {
  for (double ratio = 1.0; ratio < kMaxRadiusRatio; ratio += kRadiusStep) {
    const auto transit = TransitOf(task, WithTurnRadius(tightest, ratio * tightest.turn_radius));
    if (transit) return transit;
  }
  return std::nullopt;
}

}  // namespace freelsd
