#include "tests/engine/glide/path_planner.h"

#include <algorithm>
#include <cmath>

namespace freelsd {
namespace {

constexpr double kStepM = 1.0;

// Turn to one side (1 is right) that points at the place, and the straight way to it; nothing if
// the place lies inside the circle of the turn.
std::optional<TurnPath> TurnTowards(const Stance& from,
                                    const Eigen::Vector2d& place,
                                    double sense,
                                    double radius) {
  const Eigen::Vector2d centre =
      from.place + sense * radius * DirectionOf(from.heading + 0.5 * kPi);
  const Eigen::Vector2d way = place - centre;
  const double squared = way.squaredNorm() - radius * radius;
  if (squared < 0.0) return std::nullopt;
  const double straight = std::sqrt(squared);
  // From the centre, the tangent's point lies before the place in the sense of the turn.
  const double heading = HeadingOf(way) + sense * std::atan2(radius, straight);
  double turn = std::fmod(sense * (heading - from.heading), 2.0 * kPi);
  if (turn < -1e-9) turn += 2.0 * kPi;
  return TurnPath{sense * std::max(0.0, turn), straight, 0.0, 0.0};
}

double TimeOf(const TurnPath& path, const Performance& performance) {
  return (path.Turned() * performance.turn_radius + path.straight_m) / performance.Airspeed();
}

// Of all that gets there in the time or less, to one side.
std::optional<TurnPath> PathIn(const TransitTask& task,
                               double time,
                               double sense,
                               const Performance& performance) {
  return TurnTowards(task.from, task.to.place - task.wind * time, sense, performance.turn_radius);
}

// The times up to the last at which a path to this side takes exactly the time that passes.
std::vector<double> ArrivalTimes(const TransitTask& task,
                                 double sense,
                                 const Performance& performance,
                                 double last_time) {
  const auto excess = [&](double time) {
    const auto path = PathIn(task, time, sense, performance);
    return path ? TimeOf(*path, performance) - time : 1e9;
  };
  // Short, because a step over a jump and an arrival would miss the arrival.
  constexpr double kCoarseS = 0.1;
  std::vector<double> times;
  double now = excess(0.0);
  for (double time = 0.0; time < last_time; time += kCoarseS) {
    const double then = excess(time + kCoarseS);
    if ((now >= 0.0) != (then >= 0.0)) {
      double low = time, high = time + kCoarseS;
      for (int i = 0; i < 50; ++i) {
        const double middle = 0.5 * (low + high);
        ((excess(middle) >= 0.0) == (now >= 0.0) ? low : high) = middle;
      }
      // A jump is no arrival.
      if (std::abs(excess(high)) < 0.01) times.push_back(high);
    }
    now = then;
  }
  return times;
}

Transit TransitWith(const TurnPath& path, const Performance& performance) {
  const double turning = path.Turned() * performance.turn_radius / performance.Airspeed();
  const double time = TimeOf(path, performance);
  return {path,
          performance,
          time,
          turning * performance.turning_sink_rate +
              (time - turning) * performance.straight.sink_rate_mps};
}

bool IsClear(const TransitTask& task,
             const Transit& transit,
             double height,
             const FineGround& ground,
             const ReachLimits& limits) {
  const Performance& performance = transit.performance;
  const double airspeed = performance.Airspeed();
  const double turn = transit.path.first_turn;
  const double turned_m = std::abs(turn) * performance.turn_radius;
  const double length = turned_m + transit.path.straight_m;
  const double sense = turn < 0.0 ? -1.0 : 1.0;
  const Eigen::Vector2d centre = task.from.place + sense * performance.turn_radius *
                                                       DirectionOf(task.from.heading + 0.5 * kPi);
  const int num_steps = static_cast<int>(std::ceil(length / kStepM));
  for (int i = 0; i <= num_steps; ++i) {
    const double s = length * i / std::max(1, num_steps);
    const double angle = sense * std::min(s, turned_m) / performance.turn_radius;
    Eigen::Vector2d place = centre - sense * performance.turn_radius *
                                         DirectionOf(task.from.heading + angle + 0.5 * kPi);
    place += std::max(0.0, s - turned_m) * DirectionOf(task.from.heading + angle);
    place += s / airspeed * task.wind;
    const double lost = std::min(s, turned_m) / airspeed * performance.turning_sink_rate +
                        std::max(0.0, s - turned_m) / airspeed * performance.straight.sink_rate_mps;
    if (height - lost < ground.HeightAt(place) + limits.terrain_clearance_m) return false;
  }
  return height - transit.height_lost >= ground.HeightAt(task.to.place) + limits.arrival_height_m;
}

}  // namespace

double FineGround::HeightAt(const Eigen::Vector2d& place) const {
  const auto cell = grid.CellAt(place);
  if (!cell || !std::isfinite(top(*cell))) return assumed_height;
  return static_cast<double>(top(*cell));
}

std::vector<Transit> TransitsTo(const TransitTask& task,
                                const Performance& performance,
                                double last_time) {
  std::vector<Transit> transits;
  for (const double sense : {1.0, -1.0}) {
    for (const double time : ArrivalTimes(task, sense, performance, last_time)) {
      transits.push_back(TransitWith(*PathIn(task, time, sense, performance), performance));
    }
  }
  return transits;
}

bool IsReached(const GlideStart& start,
               const Eigen::Vector2d& place,
               const FineGround& ground,
               const Aircraft& aircraft,
               const ReachLimits& limits) {
  const GlideOptions options;
  const Performance performance = PerformanceOf(aircraft);
  const double height =
      start.position_in_world.z() -
      TimeBetweenHeadings(start, performance, options) * performance.turning_sink_rate;
  const double last_time = (height - ground.lowest_height) / performance.straight.sink_rate_mps;
  for (const Eigen::Vector2d& wind : WindsToReckonWith(start, aircraft, options)) {
    // A straight line without a turn loses the least.
    GlideStart in_wind = start;
    in_wind.wind_in_world = wind;
    const auto least = LeastHeightLost(in_wind, place, 0.0, performance.straight);
    if (!least || height - *least < ground.HeightAt(place) + limits.arrival_height_m) return false;
    for (const double heading : HeadingsToReckonWith(start, options)) {
      const TransitTask task =
          TransitTaskOf(start.position_in_world.head<2>(), heading, place, 0.0, wind, performance);
      const auto transits = TransitsTo(task, performance, last_time);
      if (std::none_of(transits.begin(), transits.end(), [&](const Transit& transit) {
            return IsClear(task, transit, height, ground, limits);
          })) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace freelsd
