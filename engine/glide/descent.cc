#include <algorithm>
#include <cmath>

#include "engine/approach/approach.h"
#include "engine/glide/glide.h"
#include "engine/glide/performance.h"
#include "engine/glide/transit.h"

namespace freelsd {
namespace {

constexpr double kTurnStep = 10.0 * kPi / 180.0;  // between points of a turn
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

// What all paths to one approach share.
struct Task {
  TransitTask transit;
  // Height above the start of the final.
  double height = 0.0;
};

// The planner computes its circle for the landing speed.
StraightGlide AtLandingSpeed(Aircraft aircraft) {
  aircraft.glide_airspeed_mps = aircraft.landing_airspeed_mps;
  return StraightGlideOf(aircraft);
}

// How the height above the start of the final is lost.
struct Choice {
  Transit transit;
  std::optional<Circle> circle;
  int num_circles = 0;
  double surplus_height = 0.0;
};

std::optional<Choice> Choose(const Task& task,
                             const Approach& approach,
                             const Aircraft& aircraft,
                             const Performance& tightest) {
  const std::optional<Transit> shortest = TightestTransit(task.transit, tightest);
  if (!shortest || shortest->height_lost > task.height) return std::nullopt;
  Choice choice{*shortest, CircleOf(approach, task.transit.wind, AtLandingSpeed(aircraft))};
  choice.surplus_height = task.height - shortest->height_lost;
  if (!choice.circle) return choice;
  const double lost_in_circle = choice.circle->HeightLost();
  choice.num_circles = static_cast<int>(choice.surplus_height / lost_in_circle);
  choice.surplus_height -= choice.num_circles * lost_in_circle;
  return choice;
}

// Appends points as the aircraft flies.
class Flight {
 public:
  Flight(const TransitTask& task, const Eigen::Vector3d& position_in_world)
      : wind_(task.wind), stance_in_air_(task.from), height_(position_in_world.z()) {
    points.push_back({position_in_world, 0.0});
  }

  void Turn(double angle, const Performance& performance) {
    const int num_steps = static_cast<int>(std::ceil(std::abs(angle) / kTurnStep));
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

Descent Flown(const TransitTask& task,
              const Choice& choice,
              const Eigen::Vector3d& position_in_world,
              const Approach& approach,
              const Aircraft& aircraft) {
  Flight flight(task, position_in_world);
  const TurnPath& path = choice.transit.path;
  const Performance& performance = choice.transit.performance;
  flight.Turn(path.first_turn, performance);
  flight.Straight(path.straight_m, performance);
  flight.Turn(path.middle_turn, performance);
  flight.Turn(path.last_turn, performance);
  Descent descent;
  descent.arrival = flight.points.size() - 1;
  // The iteration for the drift leaves a few centimetres.
  flight.points.back().position_in_world.head<2>() = approach.approach_start_in_world.head<2>();
  for (int i = 0; i < choice.num_circles; ++i) flight.Around(*choice.circle);
  descent.final_start = flight.points.size() - 1;
  const double landing_speed =
      aircraft.landing_airspeed_mps * std::cos(RadFromDeg(aircraft.flight_path_angle_deg));
  const double time = approach.approach_distance / approach.ground_speed.value_or(landing_speed);
  flight.points.push_back({approach.touchdown_in_world, flight.points.back().time_s + time});
  descent.points = std::move(flight.points);
  descent.num_circles = choice.num_circles;
  descent.surplus_height_m = std::max(0.0, choice.surplus_height);
  return descent;
}

}  // namespace

std::optional<Descent> PlanDescent(const GlideStart& start,
                                   const Approach& approach,
                                   const Aircraft& aircraft,
                                   const GlideOptions& options) {
  const Performance tightest = PerformanceOf(aircraft);
  const Eigen::Vector2d wind = start.wind_in_world.value_or(Eigen::Vector2d::Zero());
  std::optional<TransitTask> worst;
  double most_lost = -1.0;
  for (const double heading : HeadingsToReckonWith(start, options)) {
    const TransitTask task = TransitTaskOf(start.position_in_world.head<2>(),
                                           heading,
                                           approach.approach_start_in_world.head<2>(),
                                           approach.heading,
                                           wind,
                                           tightest);
    const auto transit = TightestTransit(task, tightest);
    if (!transit) return std::nullopt;
    if (transit->height_lost > most_lost) worst = task;
    most_lost = std::max(most_lost, transit->height_lost);
  }
  const Task task{*worst, start.position_in_world.z() - approach.approach_start_in_world.z()};
  const std::optional<Choice> choice = Choose(task, approach, aircraft, tightest);
  if (!choice) return std::nullopt;
  return Flown(task.transit, *choice, start.position_in_world, approach, aircraft);
}

}  // namespace freelsd
