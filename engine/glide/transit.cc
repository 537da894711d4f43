#include "engine/glide/transit.h"

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

// Winds that differ from `wind` by `difference_mps`, evenly in every direction.
std::vector<Eigen::Vector2d> WindsAround(const Eigen::Vector2d& wind,
                                         double difference_mps,
                                         const GlideOptions& options) {
  std::vector<Eigen::Vector2d> winds;
  winds.reserve(static_cast<size_t>(options.num_unknown_winds));
  for (int i = 0; i < options.num_unknown_winds; ++i) {
    winds.push_back(wind + difference_mps * DirectionOf(2.0 * kPi * i / options.num_unknown_winds));
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
    std::vector<Eigen::Vector2d> winds =
        WindsAround(Eigen::Vector2d::Zero(), options.unknown_wind_mps, options);
    winds.insert(winds.begin(), Eigen::Vector2d::Zero());
    return winds;
  }
  std::vector<Eigen::Vector2d> winds;
  if (start.wind_sd_mps > 0.0) {
    winds =
        WindsAround(*start.wind_in_world, options.num_wind_deviations * start.wind_sd_mps, options);
  }
  const double turned = RadFromDeg(aircraft.crosswind_uncertainty_deg);
  for (const double angle : {0.0, turned, -turned}) {
    winds.push_back(Eigen::Rotation2Dd(angle) * *start.wind_in_world);
  }
  return winds;
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
