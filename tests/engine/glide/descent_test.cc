#include <algorithm>
#include <cmath>
#include <random>

#include <doctest/doctest.h>

#include "engine/approach/approach.h"
#include "engine/glide/glide.h"
#include "engine/glide/performance.h"
#include "engine/glide/shortest_turns.h"

namespace freelsd {
namespace {

// What a recall may differ from the flight: of the height at the start of the final.
constexpr double kMaxHeightErrorM = 5.0;
constexpr double kMaxHeightErrorRatio = 0.05;
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

// A point mass that steers towards a point of the path ahead of it, with limited bank.
class Simulation {
 public:
  Simulation(const Descent& descent, const GlideStart& start, const Aircraft& aircraft)
      : points_(descent.points),
        arrival_(descent.arrival),
        performance_(PerformanceOf(aircraft)),
        wind_(start.wind_in_world.value_or(Eigen::Vector2d::Zero())),
        position_(start.position_in_world),
        max_lateral_(9.81 * std::tan(RadFromDeg(aircraft.max_bank_deg + kExtraBankDeg))) {
    heading_ = AirHeading(start.heading.value_or(0.0), wind_, performance_.Airspeed());
  }

  // Flies until the point `end` is abeam. Returns the height there.
  double FlyTo(size_t end, const Aircraft& aircraft) {
    if (end > arrival_) {
      Aircraft slow = aircraft;
      slow.glide_airspeed_mps = slow.landing_airspeed_mps;
      performance_ = PerformanceOf(slow);
    }
    while (segment_ + 1 <= end && time_ < 2.0 * points_.back().time_s + 60.0) Step();
    return position_.z();
  }

  double max_track_error() const { return max_track_error_; }

 private:
  static constexpr double kStep = 0.05;
  static constexpr double kExtraBankDeg = 8.0;
  static constexpr double kAheadS = 1.2;

  Eigen::Vector2d PlaceOf(size_t i) const { return points_[i].position_in_world.head<2>(); }

  // Moves on to the segment beside the aircraft. Returns the point ahead on the path.
  Eigen::Vector2d Ahead() {
    for (; segment_ + 1 < points_.size(); ++segment_) {
      const Eigen::Vector2d along = PlaceOf(segment_ + 1) - PlaceOf(segment_);
      const double length = along.norm();
      const Eigen::Vector2d done = position_.head<2>() - PlaceOf(segment_);
      if (length > 1e-6 && done.dot(along) < length * length) {
        const double aside = done.x() * along.y() / length - done.y() * along.x() / length;
        max_track_error_ = std::max(max_track_error_, std::abs(aside));
        return PointFrom(segment_, done.dot(along) / length + kAheadS * performance_.Airspeed());
      }
    }
    return PlaceOf(points_.size() - 1);
  }

  Eigen::Vector2d PointFrom(size_t i, double length) const {
    for (; i + 1 < points_.size(); ++i) {
      const Eigen::Vector2d along = PlaceOf(i + 1) - PlaceOf(i);
      if (length <= along.norm()) return PlaceOf(i) + length * along.normalized();
      length -= along.norm();
    }
    return PlaceOf(points_.size() - 1);
  }

  void Step() {
    const Eigen::Vector2d way = Ahead() - position_.head<2>();
    const double wanted = AirHeading(HeadingOf(way), wind_, performance_.Airspeed());
    const double speed = performance_.Airspeed();
    const double lateral =
        std::clamp(2.0 * speed / kAheadS * std::sin(std::remainder(wanted - heading_, 2.0 * kPi)),
                   -max_lateral_,
                   max_lateral_);
    heading_ += lateral / speed * kStep;
    const Eigen::Vector2d ground = speed * DirectionOf(heading_) + wind_;
    position_.head<2>() += kStep * ground;
    position_.z() -= kStep * SinkRateTurning(performance_.straight, std::abs(lateral));
    time_ += kStep;
  }

  const std::vector<DescentPoint>& points_;
  size_t arrival_;
  // Of the glide; from the arrival on, at landing speed.
  Performance performance_;
  Eigen::Vector2d wind_;
  Eigen::Vector3d position_;
  double heading_ = 0.0;
  double max_lateral_;
  size_t segment_ = 0;
  double time_ = 0.0;
  double max_track_error_ = 0.0;
};

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
  const Eigen::Vector2d wind = speed(random) * DirectionOf(angle(random));
  made.start = {{place(random), place(random), height(random)}, angle(random), wind};
  const bool is_left = angle(random) < 0.0;
  made.approach = ApproachAt({place(random), place(random)},
                             wind,
                             made.aircraft,
                             is_left ? LoiterDirection::kLeft : LoiterDirection::kRight);
  return made;
}

TEST_CASE("descent: 1000 random paths are flown with the heights that they promise") {
  std::mt19937 random(23);
  int num_flown = 0;
  int num_with_surplus = 0;
  double worst_height_error = 0.0;
  double worst_track_error = 0.0;
  while (num_flown < 1000) {
    const Case made = RandomCase(random);
    const auto descent = PlanDescent(made.start, made.approach, made.aircraft, {});
    if (!descent) continue;
    ++num_flown;
    num_with_surplus += descent->surplus_height_m > kMaxHeightErrorM;
    Simulation simulation(*descent, made.start, made.aircraft);
    const double arrival = descent->points[descent->arrival].position_in_world.z();
    const double lost = made.start.position_in_world.z() - arrival;
    if (descent->num_circles > 0) {
      const double in_circles = descent->points[descent->arrival].position_in_world.z() -
                                descent->points[descent->final_start].position_in_world.z();
      CHECK(descent->surplus_height_m < in_circles / descent->num_circles);
    }
    const double error = std::abs(simulation.FlyTo(descent->arrival, made.aircraft) - arrival);
    CHECK(error <= kMaxHeightErrorM + kMaxHeightErrorRatio * lost);
    worst_height_error = std::max(worst_height_error, error);
    const double begin = descent->points[descent->final_start].position_in_world.z();
    const double total_lost = made.start.position_in_world.z() - begin;
    CHECK(std::abs(simulation.FlyTo(descent->final_start, made.aircraft) - begin) <=
          kMaxHeightErrorM + kMaxHeightErrorRatio * total_lost);
    CHECK(simulation.max_track_error() <= kMaxTrackErrorM);
    worst_track_error = std::max(worst_track_error, simulation.max_track_error());
  }
  MESSAGE("worst height error " << worst_height_error << " m, worst track error "
                                << worst_track_error << " m, surplus above 5 m in "
                                << num_with_surplus);
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

TEST_CASE("descent: never arrives lower than the glide's worst case") {
  std::mt19937 random(6);
  int num_without_path = 0;
  for (int i = 0; i < 300; ++i) {
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
  CHECK(num_without_path <= 3);
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
