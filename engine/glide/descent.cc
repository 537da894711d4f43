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
  double HeightLost() const { return -points.back().position_in_world.z(); }
  double HeightLostFrom(size_t point) const {
    return HeightLost() + points[point].position_in_world.z();
  }
};

// How a path loses height on the circle. It joins the circle at one of its points, and flies along
// it to the start of the final; 0: it comes to the start of the final itself. Then it flies whole
// circles.
struct Laps {
  size_t joining = 0;
  int num_circles = 0;

  double HeightLost(const std::optional<Circle>& circle) const {
    if (!circle) return 0.0;
    return num_circles * circle->HeightLost() +
           (joining > 0 ? circle->HeightLostFrom(joining) : 0.0);
  }
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
  Performance tightest;
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
      worst = Task{transit_task, *transit, tightest, 0.0, std::nullopt};
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

  // The last point and the circle's point `from` are the same place.
  void Along(const Circle& circle, size_t from) {
    const DescentPoint begin = points.back();
    const DescentPoint& first = circle.points[from];
    for (size_t i = from + 1; i < circle.points.size(); ++i) {
      const DescentPoint& next = circle.points[i];
      points.push_back({begin.position_in_world + next.position_in_world - first.position_in_world,
                        begin.time_s + next.time_s - first.time_s});
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

// Where and how an aircraft lands.
struct LandingTask {
  const GlideStart& start;
  const Approach& approach;
  const Aircraft& aircraft;
};

double TimeOnFinal(const LandingTask& landing) {
  const Aircraft& aircraft = landing.aircraft;
  const double landing_speed =
      aircraft.landing_airspeed_mps * std::cos(RadFromDeg(aircraft.flight_path_angle_deg));
  return landing.approach.approach_distance / landing.approach.ground_speed.value_or(landing_speed);
}

Descent Flown(const Task& task, const Way& way, const Laps& laps, const LandingTask& landing) {
  Flight flight(task.transit, landing.start.position_in_world);
  Descent descent;
  for (size_t i = 0; i < way.legs.size(); ++i) {
    if (i == way.num_legs_to_decision) descent.decision = flight.points.size() - 1;
    flight.Turn(way.legs[i].turn, way.performance);
    flight.Straight(way.legs[i].straight_m, way.performance);
  }
  descent.joining = flight.points.size() - 1;
  // The iteration for the drift leaves a few centimetres.
  flight.points.back().position_in_world.head<2>() = task.transit.to.place;
  if (laps.joining > 0) flight.Along(*task.circle, laps.joining);
  descent.arrival = flight.points.size() - 1;
  for (int i = 0; i < laps.num_circles; ++i) flight.Along(*task.circle, 0);
  descent.final_start = flight.points.size() - 1;
  flight.points.push_back(
      {landing.approach.touchdown_in_world, flight.points.back().time_s + TimeOnFinal(landing)});
  descent.points = std::move(flight.points);
  descent.num_circles = laps.num_circles;
  descent.surplus_height_m =
      std::max(0.0, task.height - laps.HeightLost(task.circle) - way.height_lost);
  return descent;
}

// The same task to a point of the circle. Nothing if no path is found.
std::optional<Task> JoiningAt(const Task& task, size_t point, const Approach& approach) {
  const double side = approach.loiter_direction == LoiterDirection::kLeft ? -1.0 : 1.0;
  const double heading =
      approach.heading + side * 2.0 * kPi * static_cast<double>(point) / kNumCirclePoints;
  const Performance& performance = task.tightest;
  Task joining = task;
  joining.transit.to = {approach.approach_start_in_world.head<2>() +
                            task.circle->points[point].position_in_world.head<2>(),
                        AirHeading(heading, task.transit.wind, performance.Airspeed())};
  const auto transit = TightestTransit(joining.transit, performance);
  if (!transit) return std::nullopt;
  joining.shortest = *transit;
  return joining;
}

// The first path that joins the circle and is taken, with the shortest part of the circle.
std::optional<Descent> Joined(const Task& task,
                              int num_circles,
                              const LandingTask& landing,
                              double max_surplus_m,
                              const std::function<bool(const Descent&)>& takes) {
  if (!task.circle) return std::nullopt;
  for (size_t point = task.circle->points.size() - 2; point > 0; --point) {
    const Laps laps{point, num_circles};
    const auto joining = JoiningAt(task, point, landing.approach);
    if (!joining) continue;
    const double surplus =
        task.height - laps.HeightLost(task.circle) - joining->shortest.height_lost;
    if (surplus < 0.0 || surplus > max_surplus_m) continue;
    Descent descent = Flown(*joining, WayOf(joining->shortest), laps, landing);
    if (takes(descent)) return descent;
  }
  return std::nullopt;
}

}  // namespace

std::optional<Descent> PlanDescent(const GlideStart& start,
                                   const Approach& approach,
                                   const Aircraft& aircraft,
                                   const GlideOptions& options) {
  const std::optional<Task> task = TaskOf(start, approach, aircraft, options);
  if (!task) return std::nullopt;
  return Flown(
      *task, WayOf(task->shortest), {0, task->MaxNumCircles()}, {start, approach, aircraft});
}

std::optional<Descent> PlanLongerDescent(const GlideStart& start,
                                         const Approach& approach,
                                         const Aircraft& aircraft,
                                         const GlideOptions& options,
                                         const std::function<bool(const Descent&)>& takes) {
  const std::optional<Task> task = TaskOf(start, approach, aircraft, options);
  if (!task) return std::nullopt;
  const LandingTask landing{start, approach, aircraft};
  std::optional<Descent> taken;
  const int most = task->MaxNumCircles();
  const int least = std::max(0, most - 1);
  // One circle less leaves more height for a way that can lose no less than a whole turn.
  for (int num_circles = most; num_circles >= least; --num_circles) {
    const Laps laps{0, num_circles};
    const auto is_taken = [&](const Way& way) {
      taken = Flown(*task, way, laps, landing);
      return takes(*taken);
    };
    const double height_lost = task->height - laps.HeightLost(task->circle);
    if (WayLosing(task->transit, task->shortest, height_lost, is_taken)) return taken;
  }
  for (int num_circles = most; num_circles >= least; --num_circles) {
    taken = Joined(*task, num_circles, landing, options.max_surplus_m, takes);
    if (taken) return taken;
  }
  return std::nullopt;
}

}  // namespace freelsd
