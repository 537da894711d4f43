#include "engine/glide/detour.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

namespace freelsd {
namespace {

constexpr double kMaxDetourTime = 3600.0;  // as in transit.cc
constexpr double kDetourTimeTolerance = 0.01;
constexpr int kMaxDetourIterations = 40;
constexpr int kNumBisections = 40;
// A wider turn is hardly one, and takes the aircraft far away.
constexpr double kMaxWidening = 3.0;
// A sharper bend takes the aircraft back rather than aside.
constexpr double kMaxBend = 70.0 * kPi / 180.0;
constexpr int kNumSteps = 24;

// What makes a way longer than the shortest. All 0: nothing does.
struct Detour {
  // Of the radius of all turns, in radii of the shortest transit's.
  double widening = 0.0;
  // Turned at the beginning, before the straight piece that is flown first. Radians to the right.
  double aside = 0.0;
  double straight_first_m = 0.0;
  double straight_last_m = 0.0;
  // Angle to the right of the straight piece, at both of its ends. The way comes back to it by a
  // turn of twice the angle to the left, half way.
  double bend = 0.0;
  int num_whole_turns = 0;
};

// A way in the making, for one time of flight.
struct Shape {
  TurnPath path;
  // Length of each leg beside the straight piece.
  double bend_leg_m = 0.0;
  double time = 0.0;
  double height_lost = 0.0;
};

class Detours {
 public:
  Detours(const TransitTask& task, const Transit& shortest) : task_(task), shortest_(shortest) {}

  // The way's time is what decides where the place is, in the air. Nothing if no time fits, or if
  // the straight piece is too short to bend. `time` is a guess.
  std::optional<Way> WayBy(const Detour& detour, double time) const {
    const Performance performance = WithTurnRadius(
        shortest_.performance, (1.0 + detour.widening) * shortest_.performance.turn_radius);
    double last_time = 0.0;
    double last_error = 0.0;
    for (int i = 0; i < kMaxDetourIterations; ++i) {
      const std::optional<Shape> shape = ShapeAfter(detour, performance, time);
      if (!shape) return std::nullopt;
      const double error = shape->time - time;
      if (std::abs(error) < kDetourTimeTolerance) {
        return Way{LegsOf(detour, *shape),
                   NumLegsToDecision(detour),
                   performance,
                   shape->time,
                   shape->height_lost};
      }
      // The secant of the last two errors, where it is of use: they come close in a few steps.
      const double slope = i > 0 ? (error - last_error) / (time - last_time) : 0.0;
      const bool is_of_use = slope < -0.2 && slope > -5.0;
      last_time = time;
      last_error = error;
      time = std::clamp(is_of_use ? time - error / slope : shape->time, 0.0, kMaxDetourTime);
    }
    return std::nullopt;
  }

 private:
  std::optional<Shape> ShapeAfter(const Detour& detour,
                                  const Performance& performance,
                                  double time) const {
    const double radius = performance.turn_radius;
    const Stance from = After(task_.from, detour, radius);
    const Stance to{
        task_.to.place - task_.wind * time - detour.straight_last_m * DirectionOf(task_.to.heading),
        task_.to.heading};
    Shape shape{ShortestTurns(from, to, radius)};
    const double bend = std::abs(detour.bend);
    double straight = shape.path.straight_m;
    if (bend > 0.0) {
      const double between = straight - 4.0 * radius * std::sin(bend);
      if (between < 0.0) return std::nullopt;
      shape.bend_leg_m = 0.5 * between / std::cos(bend);
      straight = 2.0 * shape.bend_leg_m;
    }
    straight += detour.straight_first_m + detour.straight_last_m;
    const double turned = shape.path.Turned() + 4.0 * bend + std::abs(detour.aside) +
                          2.0 * kPi * detour.num_whole_turns;
    const double turning = turned * radius / performance.Airspeed();
    const double gliding = straight / performance.Airspeed();
    shape.time = turning + gliding;
    shape.height_lost =
        turning * performance.turning_sink_rate + gliding * performance.straight.sink_rate_mps;
    return shape;
  }

  // Where the shortest turns begin.
  static Stance After(Stance stance, const Detour& detour, double radius) {
    const double chord = 2.0 * radius * std::sin(0.5 * std::abs(detour.aside));
    stance.place += chord * DirectionOf(stance.heading + 0.5 * detour.aside);
    stance.heading += detour.aside;
    stance.place += detour.straight_first_m * DirectionOf(stance.heading);
    return stance;
  }

  static std::vector<Leg> LegsOf(const Detour& detour, const Shape& shape) {
    const TurnPath& path = shape.path;
    const double whole_turns = std::copysign(2.0 * kPi * detour.num_whole_turns, path.first_turn);
    std::vector<Leg> legs{{whole_turns + detour.aside, detour.straight_first_m}};
    if (detour.bend != 0.0) {
      legs.push_back({path.first_turn, 0.0});
      legs.push_back({detour.bend, shape.bend_leg_m});
      legs.push_back({-2.0 * detour.bend, shape.bend_leg_m});
      legs.push_back({detour.bend, 0.0});
    } else {
      legs.push_back({path.first_turn, path.straight_m});
      legs.push_back({path.middle_turn, 0.0});
    }
    legs.push_back({path.last_turn, detour.straight_last_m});
    return legs;
  }

  static size_t NumLegsToDecision(const Detour& detour) {
    if (detour.bend != 0.0 || detour.straight_last_m > 0.0) return 3;
    const bool is_early =
        detour.num_whole_turns > 0 || detour.aside != 0.0 || detour.straight_first_m > 0.0;
    return is_early ? 1 : 3;
  }

  const TransitTask& task_;
  const Transit& shortest_;
};

// Ways of one kind, by a number from 0 (the shortest way, or the least that this kind can do) to 1.
using Kind = std::function<Detour(double)>;

// The way of this kind that loses the height. The height lost jumps where the shortest turns change
// their kind: a jump over the wanted height gives no way there.
std::optional<Way> WayOfKind(const Detours& detours,
                             const Kind& kind,
                             const Transit& shortest,
                             double height_lost) {
  std::optional<Way> before = detours.WayBy(kind(0.0), shortest.time);
  for (int step = 1; step <= kNumSteps; ++step) {
    double most = static_cast<double>(step) / kNumSteps;
    double least = most - 1.0 / kNumSteps;
    const double guess = before ? before->time : shortest.time;
    std::optional<Way> way = detours.WayBy(kind(most), guess);
    const bool is_between = before && way && before->height_lost <= height_lost &&
                            way->height_lost >= height_lost - kWayHeightTolerance;
    before = way;
    if (!is_between) continue;
    double time = guess;
    for (int i = 0; i < kNumBisections; ++i) {
      const double middle = 0.5 * (least + most);
      way = detours.WayBy(kind(middle), time);
      if (!way) break;
      const double left = height_lost - way->height_lost;
      if (left >= 0.0 && left <= kWayHeightTolerance) return way;
      (left > 0.0 ? least : most) = middle;
      time = way->time;
    }
  }
  return std::nullopt;
}

std::vector<Kind> KindsFor(const Transit& shortest, double height_lost) {
  // Flown straight, there and back, this loses all of the height that is left.
  const StraightGlide& glide = shortest.performance.straight;
  const double length =
      (height_lost - shortest.height_lost) / glide.sink_rate_mps * glide.airspeed_mps;
  std::vector<Kind> kinds;
  kinds.emplace_back([length](double x) { return Detour{.straight_last_m = length * x}; });
  kinds.emplace_back([](double x) { return Detour{.widening = (kMaxWidening - 1.0) * x}; });
  for (const double side : {1.0, -1.0}) {
    kinds.emplace_back([side](double x) { return Detour{.bend = side * kMaxBend * x}; });
  }
  kinds.emplace_back([length](double x) { return Detour{.straight_first_m = length * x}; });
  kinds.emplace_back(
      [](double x) { return Detour{.widening = (kMaxWidening - 1.0) * x, .num_whole_turns = 1}; });
  for (const double aside : {1.0, -1.0, 2.0, -2.0}) {
    kinds.emplace_back([length, aside](double x) {
      return Detour{.aside = aside * kPi / 4.0, .straight_first_m = length * x};
    });
  }
  return kinds;
}

}  // namespace

Way WayOf(const Transit& transit) {
  const TurnPath& path = transit.path;
  return {{{path.first_turn, path.straight_m}, {path.middle_turn, 0.0}, {path.last_turn, 0.0}},
          0,
          transit.performance,
          transit.time,
          transit.height_lost};
}

std::optional<Way> WayLosing(const TransitTask& task,
                             const Transit& shortest,
                             double height_lost,
                             const std::function<bool(const Way&)>& takes) {
  const Detours detours(task, shortest);
  for (const Kind& kind : KindsFor(shortest, height_lost)) {
    auto way = WayOfKind(detours, kind, shortest, height_lost);
    if (way && takes(*way)) return way;
  }
  return std::nullopt;
}

}  // namespace freelsd
