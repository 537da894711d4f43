#include "engine/glide/glide.h"

#include <cmath>
#include <random>

#include <doctest/doctest.h>

#include "engine/glide/shortest_turns.h"
#include "tests/engine/refusal.h"

namespace freelsd {
namespace {

constexpr double kMaxLengthErrorM = 1e-6;
constexpr double kMaxHeightErrorM = 0.1;

double LengthOf(const TurnPath& path, double radius_m) {
  return path.Turned() * radius_m + path.straight_m;
}

TEST_CASE("glide: straight ahead the shortest turns are the straight line") {
  const TurnPath path = ShortestTurns({{0, 0}, 0.0}, {{0, 500}, 0.0}, 80.0);
  CHECK(LengthOf(path, 80.0) == doctest::Approx(500.0).epsilon(kMaxLengthErrorM));
}

TEST_CASE("glide: a quarter turn to a place on the circle is that arc") {
  // From the origin northwards, a right turn about (80, 0) ends at (80, 80) eastwards.
  const TurnPath path = ShortestTurns({{0, 0}, 0.0}, {{80, 80}, kPi / 2}, 80.0);
  CHECK(LengthOf(path, 80.0) == doctest::Approx(40.0 * kPi).epsilon(kMaxLengthErrorM));
}

TEST_CASE("glide: turning back on a far parallel is half a circle and two straight pieces") {
  const TurnPath path = ShortestTurns({{0, 0}, 0.0}, {{160, -300}, kPi}, 80.0);
  CHECK(LengthOf(path, 80.0) == doctest::Approx(80.0 * kPi + 300.0).epsilon(kMaxLengthErrorM));
}

TEST_CASE("glide: reversing on the spot takes seven thirds of pi radii") {
  const TurnPath path = ShortestTurns({{0, 0}, 0.3}, {{0, 0}, 0.3 + kPi}, 50.0);
  CHECK(LengthOf(path, 50.0) == doctest::Approx(50.0 * 7.0 * kPi / 3.0).epsilon(kMaxLengthErrorM));
}

// End of a path of three pieces: turns (left positive, radians) or straight (radii).
Stance Flown(Stance stance, const double (&pieces)[3], const int (&senses)[3]) {
  constexpr int kNumSteps = 400;
  for (int piece = 0; piece < 3; ++piece) {
    const double step = pieces[piece] / kNumSteps;
    for (int i = 0; i < kNumSteps; ++i) {
      const double middle = stance.heading - senses[piece] * step / 2.0;
      const double chord = senses[piece] == 0 ? step : 2.0 * std::sin(step / 2.0);
      stance.place += chord * DirectionOf(middle);
      stance.heading -= senses[piece] * step;
    }
  }
  return stance;
}

TEST_CASE("glide: no path of three pieces that gets there is shorter than the shortest turns") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> length(0.0, 5.0);
  std::uniform_int_distribution<int> sense(-1, 1);
  for (int i = 0; i < 500; ++i) {
    const double pieces[3] = {length(random), length(random), length(random)};
    const int senses[3] = {sense(random), sense(random), sense(random)};
    const Stance from{{3.0, -2.0}, length(random)};
    const TurnPath path = ShortestTurns(from, Flown(from, pieces, senses), 1.0);
    CHECK(LengthOf(path, 1.0) <= pieces[0] + pieces[1] + pieces[2] + 1e-6);
  }
}

Aircraft Glider() { return Unpowered(*AircraftProfile("techpod"), 12.0); }

GlideStart StartAt(double height,
                   std::optional<double> heading,
                   const std::optional<Eigen::Vector2d>& wind_in_world) {
  return {{0, 0, height}, heading, wind_in_world};
}

double Lost(const GlideStart& start, const Eigen::Vector3d& place, double final_heading) {
  const std::optional<Glide> glide = GlideTo(start, place, final_heading, Glider(), {});
  REQUIRE(glide);
  return glide->height_lost_m;
}

TEST_CASE("glide: in still air straight ahead height is distance over glide ratio") {
  const Eigen::Vector2d calm = Eigen::Vector2d::Zero();
  const auto glide = GlideTo(StartAt(300, 0.0, calm), {0, 1200, 50}, 0.0, Glider(), {});
  REQUIRE(glide);
  CHECK(glide->height_lost_m == doctest::Approx(100.0).epsilon(kMaxHeightErrorM / 100.0));
  CHECK(glide->arrival_height_m == doctest::Approx(200.0).epsilon(kMaxHeightErrorM / 200.0));
}

TEST_CASE(
    "glide: straight into a wind that may turn, closed form for the worst of its directions") {
  // Head wind of 5 m/s exactly; turned aside it is weaker.
  const double airspeed = 13.0 * std::cos(std::atan(1.0 / 12.0));
  const double expected = 1200.0 / (airspeed - 5.0) * 13.0 * std::sin(std::atan(1.0 / 12.0));
  CHECK(Lost(StartAt(0, 0.0, Eigen::Vector2d(0, -5)), {0, 1200, 0}, 0.0) ==
        doctest::Approx(expected).epsilon(kMaxHeightErrorM / expected));
}

TEST_CASE("glide: a tail wind helps, but by no more than when it turns aside") {
  const Eigen::Vector3d place(0, 1200, 0);
  const double with_wind = Lost(StartAt(0, 0.0, Eigen::Vector2d(0, 5)), place, 0.0);
  const double airspeed = 13.0 * std::cos(std::atan(1.0 / 12.0));
  const double at_best = 1200.0 / (airspeed + 5.0) * 13.0 * std::sin(std::atan(1.0 / 12.0));
  CHECK(with_wind < 100.0);
  CHECK(with_wind > at_best);
}

TEST_CASE("glide: what is unknown costs height, never gives any") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(-1500.0, 1500.0);
  std::uniform_real_distribution<double> angle(0.0, 2.0 * kPi);
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector3d target(place(random), place(random), 0.0);
    const double heading = angle(random), final_heading = angle(random);
    const Eigen::Vector2d calm = Eigen::Vector2d::Zero();
    const double known = Lost(StartAt(0, heading, calm), target, final_heading);
    CHECK(Lost(StartAt(0, std::nullopt, calm), target, final_heading) >= known);
    CHECK(Lost(StartAt(0, heading, std::nullopt), target, final_heading) >= known);
    const auto least =
        LeastHeightLost(StartAt(0, heading, calm), target.head<2>(), 0, StraightGlideOf(Glider()));
    REQUIRE(least);
    CHECK(*least <= known + 1e-9);
  }
}

TEST_CASE("glide: a deviation of the wind costs about what two deviations of head wind cost") {
  const Aircraft aircraft = Unpowered(Aircraft{}, std::nullopt);
  const Eigen::Vector3d final_start(0.0, 2000.0, 0.0);
  GlideStart start{{0.0, 0.0, 500.0}, 0.0, Eigen::Vector2d(0.0, 0.0)};
  const auto arrival = [&] {
    return GlideTo(start, final_start, 0.0, aircraft, {}).value().arrival_height_m;
  };
  const double calm_m = arrival();
  start.wind_sd_mps = 1.0;
  const double uncertain_m = arrival();
  start.wind_sd_mps = 0.0;
  start.wind_in_world = Eigen::Vector2d(0.0, -2.0);
  CHECK(uncertain_m < calm_m - 20.0);
  CHECK(uncertain_m == doctest::Approx(arrival()).epsilon(1e-3));
}

TEST_CASE(
    "glide: a wind that may have changed and turned costs at least what each such wind costs") {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> place(-2000.0, 2000.0), angle(0.0, 2.0 * kPi);
  std::uniform_real_distribution<double> part(-1.0, 1.0);
  // So much the winds between those that are tried may cost more.
  constexpr double kBetweenRatio = 1.03;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector2d wind = (i % 5) * DirectionOf(angle(random));
    const Eigen::Vector3d target(place(random), place(random), 0.0);
    const double heading = angle(random), final_heading = angle(random);
    GlideStart start = StartAt(0, heading, wind);
    start.wind_sd_mps = 1.5;
    start.wind_turn = 0.25 * kPi;
    const auto worst = GlideTo(start, target, final_heading, Glider(), {});
    REQUIRE(worst);
    const Eigen::Rotation2Dd turned(part(random) * 0.25 * kPi);
    const double speed = std::max(0.0, wind.norm() + 3.0 * part(random));
    const double from = wind.norm() > 0.0 ? HeadingOf(wind) : angle(random);
    const Eigen::Vector2d blows = speed * (turned * DirectionOf(from));
    Aircraft aircraft = Glider();
    aircraft.crosswind_uncertainty_deg = 0.0;
    const auto glide = GlideTo(StartAt(0, heading, blows), target, final_heading, aircraft, {});
    REQUIRE(glide);
    CHECK(glide->height_lost_m <= kBetweenRatio * worst->height_lost_m + 1.0);
  }
}

TEST_CASE("glide: the least height is never more than the glide's, in any wind") {
  std::mt19937 random(13);
  std::uniform_real_distribution<double> place(-2000.0, 2000.0), angle(0.0, 2.0 * kPi);
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector2d wind = 8.0 * DirectionOf(angle(random));
    const Eigen::Vector3d target(place(random), place(random), 0.0);
    const GlideStart start = StartAt(0, angle(random), wind);
    const auto glide = GlideTo(start, target, angle(random), Glider(), {});
    const Eigen::Vector2d touchdown = target.head<2>() + 150.0 * DirectionOf(angle(random));
    const auto least = LeastHeightLost(start, touchdown, 151.0, StraightGlideOf(Glider()));
    if (!glide) continue;
    REQUIRE(least);
    CHECK(*least <= glide->height_lost_m + 1e-9);
  }
}

TEST_CASE("glide: a wind faster than the aircraft lets it nowhere upwind") {
  CHECK_FALSE(GlideTo(StartAt(5000, 0.0, Eigen::Vector2d(0, -20)), {0, 800, 0}, 0.0, Glider(), {}));
}

TEST_CASE("glide: unpowered the final is at least as steep as the glide") {
  CHECK(Unpowered(*AircraftProfile("techpod"), std::nullopt).flight_path_angle_deg ==
        doctest::Approx(DegFromRad(std::atan(1.0 / 12.0))));
  CHECK(Unpowered(*AircraftProfile("techpod"), 30.0).flight_path_angle_deg == 4.0);
  CHECK_THROWS_AS(Unpowered(*AircraftProfile("techpod"), 0.5), std::invalid_argument);
}

TEST_CASE("glide: terrain of a map counts where the line crosses it, unseen cells do not") {
  ElevationMap map;
  map.grid = {Eigen::Vector2d(-50, 550), 1.0, 100, 100};
  map.elevation = cv::Mat1f(100, 100, 20.0f);
  map.upper = map.elevation.clone();
  map.upper(50, 50) = 70.0f;  // a tree on the line, at (0.5, 499.5)
  const auto over = [&map](double x) {
    return LeastHeightOver(map.grid, map.upper, {x, 0, 100}, {x, 1000, 50});
  };
  REQUIRE(over(0.5));
  CHECK(*over(0.5) == doctest::Approx(5.0).epsilon(0.02));
  CHECK(*over(-20.0) == doctest::Approx(52.5).epsilon(0.01));
  CHECK_FALSE(over(200.0));
  map.upper = cv::Mat1f(100, 100, std::numeric_limits<float>::quiet_NaN());
  CHECK_FALSE(over(0.5));
}

TEST_CASE("glide: options out of their bounds are named") {
  CHECK_NOTHROW(GlideOptions().Check());
  CHECK(IsRefused(&GlideOptions::unknown_wind_mps, -1.0, "unknown_wind_mps"));
  CHECK(IsRefused(&GlideOptions::num_unknown_winds, 3, "num_unknown_winds"));
  CHECK(IsRefused(&GlideOptions::num_unknown_headings, 7, "num_unknown_headings"));
  CHECK(IsRefused(&GlideOptions::terrain_clearance_m, std::nan(""), "terrain_clearance_m"));
  CHECK(IsRefused(&GlideOptions::datum_penalty_m, 2000.0, "datum_penalty_m"));
}

}  // namespace
}  // namespace freelsd
