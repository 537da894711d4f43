#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "engine/approach/approach.h"
#include "engine/glide/detour.h"
#include "engine/glide/glide.h"
#include "engine/glide/performance.h"
#include "engine/glide/transit.h"

namespace freelsd {
namespace {

// Between points of a turn, at most; and how far its chords may be from the arc.
constexpr double kTurnStep = 10.0 * kPi / 180.0;
constexpr double kMaxSagitta = 0.35;
constexpr int kNumCirclePoints = 36;

// A circle over ground about a fixed centre: points relative to its start, time and height lost.
struct Circle {
  std::vector<DescentPoint> points;
  double Time() const { return points.back().time_s; }
  double HeightLost() const { return -points.back().position_in_world.z(); }
};

// Nothing if the wind is too strong to fly it.
std::optional<Circle> CircleOf(const Approach& approach,
                               const Eigen::Vector2d& wind,
                               const StraightGlide& straight) {
  const double side = approach.loiter_direction == LoiterDirection::kLeft ? -1.0 : 1.0;
  const double step = 2.0 * kPi / kNumCirclePoints;
  const double radius = approach.loiter_radius;
  const double chord = 2.0 * radius * std::sin(0.5 * step);
  Circle circle{{{}}};
  for (int i = 0; i < kNumCirclePoints; ++i) {
    const double begin = approach.heading + side * i * step;
    const Eigen::Vector2d direction = DirectionOf(begin + side * 0.5 * step);
    const auto speed = GroundSpeed(direction, wind, straight.airspeed_mps);
    if (!speed) return std::nullopt;
    const double turned =
        std::remainder(AirHeading(begin + side * step, wind, straight.airspeed_mps) -
                           AirHeading(begin, wind, straight.airspeed_mps),
                       2.0 * kPi);
    const double time = step * radius / *speed;
    const double sink = SinkRateTurning(straight, straight.airspeed_mps * std::abs(turned) / time);
    DescentPoint next = circle.points.back();
    next.position_in_world.head<2>() += chord * direction;
    next.position_in_world.z() -= time * sink;
    next.time_s += time;
    circle.points.push_back(next);
  }
  return circle;
}

// The planner computes its circle for the landing speed.
StraightGlide AtLandingSpeed(Aircraft aircraft) {
  aircraft.glide_airspeed_mps = aircraft.landing_airspeed_mps;
  return StraightGlideOf(aircraft);
}

// What all paths to one approach share.
struct Task {
  TransitTask transit;
  Transit shortest;
  // Height above the start of the final.
  double height = 0.0;
  // Nothing if the wind is too strong to fly the circle.
  std::optional<Circle> circle;

  // Circles that the shortest path has height for.
  int MaxNumCircles() const {
    if (!circle) return 0;
    return static_cast<int>((height - shortest.height_lost) / circle->HeightLost());
  }
};

// The heading that loses most height counts, of those for which a path is found. Nothing if the
// aircraft arrives below the start of the final, or if the wind is too strong.
std::optional<Task> TaskOf(const GlideStart& start,
                           const Approach& approach,
                           const Aircraft& aircraft,
                           const GlideOptions& options) {
  const Performance tightest = PerformanceOf(aircraft);
  const Eigen::Vector2d wind = start.wind_in_world.value_or(Eigen::Vector2d::Zero());
  std::optional<Task> worst;
  for (const double heading : HeadingsToReckonWith(start, options)) {
    const TransitTask transit_task = TransitTaskOf(start.position_in_world.head<2>(),
                                                   heading,
                                                   approach.approach_start_in_world.head<2>(),
                                                   approach.heading,
                                                   wind,
                                                   tightest);
    const auto transit = TightestTransit(transit_task, tightest);
    // Of one heading no path may be found (TightestTransit); the others still have theirs.
    if (!transit) continue;
    if (!worst || transit->height_lost > worst->shortest.height_lost) {
      worst = Task{transit_task, *transit, 0.0, std::nullopt};
    }
  }
  if (!worst) return std::nullopt;
  worst->height = start.position_in_world.z() - approach.approach_start_in_world.z();
  if (worst->shortest.height_lost > worst->height) return std::nullopt;
  worst->circle = CircleOf(approach, wind, AtLandingSpeed(aircraft));
  return worst;
}

// Appends points as the aircraft flies.
class Flight {
 public:
  Flight(const TransitTask& task, const Eigen::Vector3d& position_in_world)
      : wind_(task.wind), stance_in_air_(task.from), height_(position_in_world.z()) {
    points.push_back({position_in_world, 0.0});
  }

  void Turn(double angle, const Performance& performance) {
    const double off = std::min(1.0, kMaxSagitta / performance.turn_radius);
    const double most = std::min(kTurnStep, 2.0 * std::acos(1.0 - off));
    const int num_steps = static_cast<int>(std::ceil(std::abs(angle) / most));
    for (int i = 0; i < num_steps; ++i) {
      const double step = angle / num_steps;
      const double chord = 2.0 * performance.turn_radius * std::sin(0.5 * std::abs(step));
      stance_in_air_.place += chord * DirectionOf(stance_in_air_.heading + 0.5 * step);
      stance_in_air_.heading += step;
      Pass(std::abs(step) * performance.turn_radius / performance.Airspeed(),
           performance.turning_sink_rate);
    }
  }

  void Straight(double length, const Performance& performance) {
    if (length <= 0.0) return;
    stance_in_air_.place += length * DirectionOf(stance_in_air_.heading);
    Pass(length / performance.Airspeed(), performance.straight.sink_rate_mps);
  }

  // The last point and the circle's start are the same place.
  void Around(const Circle& circle) {
    const DescentPoint begin = points.back();
    for (size_t i = 1; i < circle.points.size(); ++i) {
      points.push_back({begin.position_in_world + circle.points[i].position_in_world,
                        begin.time_s + circle.points[i].time_s});
    }
  }

  std::vector<DescentPoint> points;

 private:
  void Pass(double time, double sink_rate) {
    time_ += time;
    height_ -= time * sink_rate;
    const Eigen::Vector2d place = stance_in_air_.place + time_ * wind_;
    points.push_back({{place.x(), place.y(), height_}, time_});
  }

  Eigen::Vector2d wind_;
  Stance stance_in_air_;
  double time_ = 0.0;
  double height_;
};

Descent Flown(const Task& task,
              const Way& way,
              int num_circles,
              const GlideStart& start,
              const Approach& approach,
              const Aircraft& aircraft) {
  Flight flight(task.transit, start.position_in_world);
  Descent descent;
  for (size_t i = 0; i < way.legs.size(); ++i) {
    if (i == way.num_legs_to_decision) descent.decision = flight.points.size() - 1;
    flight.Turn(way.legs[i].turn, way.performance);
    flight.Straight(way.legs[i].straight_m, way.performance);
  }
  descent.arrival = flight.points.size() - 1;
  // The iteration for the drift leaves a few centimetres.
  flight.points.back().position_in_world.head<2>() = approach.approach_start_in_world.head<2>();
  for (int i = 0; i < num_circles; ++i) flight.Around(*task.circle);
  descent.final_start = flight.points.size() - 1;
  const double landing_speed =
      aircraft.landing_airspeed_mps * std::cos(RadFromDeg(aircraft.flight_path_angle_deg));
  const double time = approach.approach_distance / approach.ground_speed.value_or(landing_speed);
  flight.points.push_back({approach.touchdown_in_world, flight.points.back().time_s + time});
  descent.points = std::move(flight.points);
  descent.num_circles = num_circles;
  const double lost_in_circles = num_circles > 0 ? num_circles * task.circle->HeightLost() : 0.0;
  descent.surplus_height_m = std::max(0.0, task.height - lost_in_circles - way.height_lost);
  return descent;
}

}  // namespace

std::optional<Descent> PlanDescent(const GlideStart& start,
                                   const Approach& approach,
                                   const Aircraft& aircraft,
                                   const GlideOptions& options) {
  const std::optional<Task> task = TaskOf(start, approach, aircraft, options);
  if (!task) return std::nullopt;
  return Flown(*task, WayOf(task->shortest), task->MaxNumCircles(), start, approach, aircraft);
}

std::optional<Descent> PlanLongerDescent(const GlideStart& start,
                                         const Approach& approach,
                                         const Aircraft& aircraft,
                                         const GlideOptions& options,
                                         const std::function<bool(const Descent&)>& takes) {
  const std::optional<Task> task = TaskOf(start, approach, aircraft, options);
  if (!task) return std::nullopt;
  std::optional<Descent> taken;
  const int most = task->MaxNumCircles();
  // One circle less leaves more height for a way that can lose no less than a whole turn.
  for (int num_circles = most; num_circles >= std::max(0, most - 1); --num_circles) {
    const double in_circles = num_circles > 0 ? num_circles * task->circle->HeightLost() : 0.0;
    const auto is_taken = [&](const Way& way) {
      taken = Flown(*task, way, num_circles, start, approach, aircraft);
      return takes(*taken);
    };
    if (WayLosing(task->transit, task->shortest, task->height - in_circles, is_taken)) {
      return taken;
    }
  }
  return std::nullopt;
}

}  // namespace freelsd
