#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "engine/approach/approach.h"
#include "engine/glide/glide.h"
#include "engine/glide/shortest_turns.h"
#include "tests/engine/glide/point_mass.h"

namespace freelsd {
namespace {

// What a recall may differ from the flight: of the height at the start of the final.
constexpr double kMaxHeightErrorM = 5.0;
constexpr double kMaxHeightErrorRatio = 0.05;
// Of the told paths, in a simulation of 1000.
constexpr double kWorstHeightErrorM = 1.1;
constexpr double kWorstTrackErrorM = 2.2;
constexpr double kMaxRatioWithoutPath = 0.01;
constexpr int kMaxNumWithSurplus = 10;
// The simulated aircraft follows the path with a delay.
constexpr double kMaxTrackErrorM = 15.0;

Aircraft Glider() { return Unpowered(*AircraftProfile("techpod"), 12.0); }

Approach ApproachAt(const Eigen::Vector2d& touchdown,
                    const Eigen::Vector2d& wind,
                    const Aircraft& aircraft,
                    LoiterDirection direction) {
  Approach approach;
  approach.heading = wind.norm() > 0.0 ? HeadingOf(-wind) : 0.7;
  approach.approach_height = aircraft.approach_height_m;
  approach.approach_distance = ApproachDistance(aircraft, wind.norm());
  approach.loiter_radius = LoiterRadius(aircraft, wind.norm());
  approach.loiter_direction = direction;
  approach.touchdown_in_world = {touchdown.x(), touchdown.y(), 3.0};
  const Eigen::Vector2d start =
      touchdown - approach.approach_distance * DirectionOf(approach.heading);
  approach.approach_start_in_world = {start.x(), start.y(), 3.0 + approach.approach_height};
  const double side = direction == LoiterDirection::kLeft ? -1.0 : 1.0;
  const Eigen::Vector2d center =
      start + approach.loiter_radius * DirectionOf(approach.heading + side * 0.5 * kPi);
  approach.loiter_center_in_world = {center.x(), center.y(), 3.0 + approach.approach_height};
  return approach;
}

TEST_CASE("glide: the pieces of the shortest turns lead to the end") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(-400.0, 400.0);
  std::uniform_real_distribution<double> angle(-kPi, kPi);
  constexpr double kRadius = 60.0;
  for (int i = 0; i < 2000; ++i) {
    const Stance from{{place(random), place(random)}, angle(random)};
    const Stance to{{place(random), place(random)}, angle(random)};
    const TurnPath path = ShortestTurns(from, to, kRadius);
    Stance at = from;
    const auto turn = [&at](double by) {
      const double chord = 2.0 * kRadius * std::sin(0.5 * std::abs(by));
      at.place += chord * DirectionOf(at.heading + 0.5 * by);
      at.heading += by;
    };
    turn(path.first_turn);
    at.place += path.straight_m * DirectionOf(at.heading);
    turn(path.middle_turn);
    turn(path.last_turn);
    CHECK((at.place - to.place).norm() < 1e-3);
    CHECK(std::abs(std::remainder(at.heading - to.heading, 2.0 * kPi)) < 1e-5);
  }
}

struct Case {
  GlideStart start;
  Approach approach;
  Aircraft aircraft;
};

Case RandomCase(std::mt19937& random) {
  std::uniform_real_distribution<double> place(-1500.0, 1500.0);
  std::uniform_real_distribution<double> height(80.0, 600.0);
  std::uniform_real_distribution<double> angle(-kPi, kPi);
  std::uniform_real_distribution<double> speed(0.0, 6.0);
  Case made{{}, {}, Glider()};
  // One draw a statement: compilers order the operands of a product differently.
  const double wind_speed = speed(random);
  const Eigen::Vector2d wind = wind_speed * DirectionOf(angle(random));
  made.start = {{place(random), place(random), height(random)}, angle(random), wind};
  const bool is_left = angle(random) < 0.0;
  made.approach = ApproachAt({place(random), place(random)},
                             wind,
                             made.aircraft,
                             is_left ? LoiterDirection::kLeft : LoiterDirection::kRight);
  return made;
}

// Flies the path and checks its heights and its track. Returns the error of the height at its
// arrival and the error of the track.
std::pair<double, double> CheckFlown(const Descent& descent, const Case& made) {
  PointMass aircraft(descent.points, descent.arrival, made.start, made.aircraft);
  const double start_height = made.start.position_in_world.z();
  const auto error_at = [&](size_t point) {
    const double told = descent.points[point].position_in_world.z();
    const double error = std::abs(aircraft.FlyTo(point) - told);
    CHECK(error <= kMaxHeightErrorM + kMaxHeightErrorRatio * (start_height - told));
    return error;
  };
  const double height_error = error_at(descent.arrival);
  error_at(descent.final_start);
  CHECK(aircraft.max_track_error_m() <= kMaxTrackErrorM);
  return {height_error, aircraft.max_track_error_m()};
}

// All longer ways, the preferred one first.
std::vector<Descent> LongerDescents(const Case& made) {
  std::vector<Descent> longer;
  const auto collect = [&longer](const Descent& descent) {
    longer.push_back(descent);
    return false;
  };
  CHECK_FALSE(PlanLongerDescent(made.start, made.approach, made.aircraft, {}, collect));
  return longer;
}

// From the joining on the path is the circle that the planner has checked.
void CheckOnCircle(const Descent& descent, const Approach& approach) {
  for (size_t i = descent.joining; i <= descent.final_start; ++i) {
    const Eigen::Vector2d from_center =
        (descent.points[i].position_in_world - approach.loiter_center_in_world).head<2>();
    CHECK(std::abs(from_center.norm() - approach.loiter_radius) < 0.5);
  }
}

struct Surpluses {
  int above_2_m = 0;
  int above_5_m = 0;

  void Count(double surplus_height_m) {
    above_2_m += surplus_height_m > 2.0;
    above_5_m += surplus_height_m > 5.0;
  }
};

TEST_CASE("descent: 1000 random paths are flown with the heights that they promise") {
  std::mt19937 random(23);
  int num_flown = 0;
  Surpluses of_shortest, of_longer;
  double worst_height_error = 0.0;
  double worst_track_error = 0.0;
  while (num_flown < 1000) {
    const Case made = RandomCase(random);
    const auto shortest = PlanDescent(made.start, made.approach, made.aircraft, {});
    if (!shortest) continue;
    ++num_flown;
    of_shortest.Count(shortest->surplus_height_m);
    if (shortest->num_circles > 0) {
      const double in_circles = shortest->points[shortest->arrival].position_in_world.z() -
                                shortest->points[shortest->final_start].position_in_world.z();
      CHECK(shortest->surplus_height_m < in_circles / shortest->num_circles);
    }
    const auto longer = LongerDescents(made);
    const Descent& told = longer.empty() ? *shortest : longer.front();
    of_longer.Count(told.surplus_height_m);
    for (const Descent* descent : {&*shortest, &told}) {
      const auto [height_error, track_error] = CheckFlown(*descent, made);
      worst_height_error = std::max(worst_height_error, height_error);
      worst_track_error = std::max(worst_track_error, track_error);
    }
  }
  CHECK(worst_height_error <= kWorstHeightErrorM);
  CHECK(worst_track_error <= kWorstTrackErrorM);
  CHECK(of_longer.above_2_m <= kMaxNumWithSurplus);
  MESSAGE("worst height error " << worst_height_error << " m, worst track error "
                                << worst_track_error << " m");
  MESSAGE("surplus above 2 m: " << of_shortest.above_2_m << " of the shortest, "
                                << of_longer.above_2_m << " of the told; above 5 m: "
                                << of_shortest.above_5_m << ", " << of_longer.above_5_m);
}

TEST_CASE("descent: begins at the aircraft, passes the start of the final, ends at the touchdown") {
  std::mt19937 random(5);
  int num_with_circles = 0;
  for (int i = 0; i < 300; ++i) {
    const Case made = RandomCase(random);
    const auto descent = PlanDescent(made.start, made.approach, made.aircraft, {});
    if (!descent) continue;
    const auto& points = descent->points;
    CHECK(points.front().position_in_world == made.start.position_in_world);
    CHECK(points.back().position_in_world == made.approach.touchdown_in_world);
    const Eigen::Vector3d off =
        points[descent->final_start].position_in_world - made.approach.approach_start_in_world;
    CHECK(off.head<2>().norm() < 1e-6);
    CHECK(off.z() == doctest::Approx(descent->surplus_height_m).epsilon(1e-6));
    for (size_t k = 1; k < points.size(); ++k) {
      CHECK(points[k].time_s >= points[k - 1].time_s);
      CHECK(points[k].position_in_world.z() <= points[k - 1].position_in_world.z());
    }
    num_with_circles += descent->num_circles > 0;
  }
  CHECK(num_with_circles > 20);
}

TEST_CASE("descent: a longer way keeps its promises up to the start of the final") {
  std::mt19937 random(7);
  int num_longer = 0;
  int num_joined = 0;
  for (int i = 0; i < 100; ++i) {
    const Case made = RandomCase(random);
    const auto shortest = PlanDescent(made.start, made.approach, made.aircraft, {});
    const auto longer = LongerDescents(made);
    CHECK((shortest || longer.empty()));
    for (const Descent& descent : longer) {
      ++num_longer;
      const auto& points = descent.points;
      const bool joins_circle = descent.joining < descent.arrival;
      num_joined += joins_circle;
      CHECK(descent.surplus_height_m <= (joins_circle ? GlideOptions{}.max_surplus_m : 0.5));
      CHECK(descent.decision <= descent.arrival);
      CHECK(points.front().position_in_world == made.start.position_in_world);
      CHECK(points.back().position_in_world == made.approach.touchdown_in_world);
      CHECK(points[descent.final_start].position_in_world.z() >=
            made.approach.approach_start_in_world.z() - 1e-6);
      CHECK(points[descent.arrival].time_s >= shortest->points[shortest->arrival].time_s - 0.1);
      if (joins_circle) CheckOnCircle(descent, made.approach);
      CheckFlown(descent, made);
    }
  }
  CHECK(num_joined > 100);
  CHECK(num_longer > 300);
}

TEST_CASE("descent: never arrives lower than the glide's worst case") {
  std::mt19937 random(6);
  int num_without_path = 0;
  constexpr int kNumCases = 3000;
  for (int i = 0; i < kNumCases; ++i) {
    Case made = RandomCase(random);
    if (i % 3 == 0) made.start.heading.reset();
    if (i % 5 == 0) made.start.wind_in_world.reset();
    const auto descent = PlanDescent(made.start, made.approach, made.aircraft, {});
    const auto glide = GlideTo(made.start,
                               made.approach.approach_start_in_world,
                               made.approach.heading,
                               made.aircraft,
                               {});
    const double start_of_final = made.approach.approach_start_in_world.z();
    num_without_path += !descent && glide && glide->arrival_height_m >= start_of_final;
    if (!descent || !glide) continue;
    // Wider turns may lose more, down to the start of the final.
    const double arrival = descent->points[descent->arrival].position_in_world.z();
    CHECK(arrival >= std::min(glide->arrival_height_m, start_of_final) - 0.5);
  }
  // Where the shortest path changes its kind at the time of arrival, only a bound is known.
  CHECK(num_without_path <= kMaxRatioWithoutPath * kNumCases);
}

TEST_CASE("descent: nothing from below, nor against a wind faster than the aircraft") {
  const Aircraft aircraft = Glider();
  const Approach approach = ApproachAt({500, 0}, {0, 0}, aircraft, LoiterDirection::kLeft);
  CHECK_FALSE(PlanDescent({{0, 0, 5.0}, 0.0, {}}, approach, aircraft, {}));
  const Eigen::Vector2d storm(-40.0, 0.0);
  CHECK_FALSE(PlanDescent({{0, 0, 400.0}, 0.0, storm}, approach, aircraft, {}));
  CHECK(PlanDescent({{0, 0, 400.0}, 0.0, {}}, approach, aircraft, {}));
}

}  // namespace
}  // namespace freelsd
