#include "engine/approach/go_around/go_around.h"

#include <cmath>
#include <random>

#include <doctest/doctest.h>

#include "tests/engine/approach/scene.h"

namespace freelsd {
namespace {

using scene::Nimble;
using scene::Scene;

// A slice may meet a cell of 1 m half a cell late or early. One metre ahead is worth 0.29 m.
constexpr double kMaxErrorM = 0.2;
constexpr double kMaxRatioError = 0.02;
// Northbound.
const Eigen::Vector2d kWind(0, -4);

Plan PlanAt(const Scene& scene, double north, const Aircraft& aircraft = Nimble()) {
  const Polygon footprint = scene::Box({-1, north - 1}, {1, north + 1});
  return scene::PlanOn(scene, scene::Request(footprint, kWind), aircraft, scene::OneWay());
}

// Heights per metre over ground: of the final, of the climb, and of both together.
struct Slopes {
  double final_slope = 0.0;
  double climb_slope = 0.0;
  double sum = 0.0;
};

Slopes SlopesOf(const Approach& approach, double climb_deg) {
  const double final_slope = approach.approach_height / approach.approach_distance;
  const double climb_slope = std::tan(RadFromDeg(climb_deg));
  return {final_slope, climb_slope, final_slope + climb_slope};
}

TEST_CASE("go-around: over flat ground it begins where the final is at the safety margin") {
  const Plan plan = PlanAt(scene::FlatMeadow(400, 400), 0.0);
  REQUIRE(plan.verdict == Verdict::kLandable);
  const Approach& approach = *plan.approach;
  REQUIRE(approach.go_around);
  const GoAround& go_around = *approach.go_around;
  const Slopes slopes = SlopesOf(approach, Nimble().climb_gradient_deg);
  CHECK(go_around.no_return_distance ==
        doctest::Approx(Nimble().safety_margin_m / slopes.final_slope));
  CHECK(go_around.start_in_world.z() == doctest::Approx(Nimble().safety_margin_m));
  CHECK((go_around.start_in_world - approach.touchdown_in_world).head<2>().norm() ==
        doctest::Approx(go_around.no_return_distance));
  // 4 m/s from ahead do not steepen it.
  CHECK(DegFromRad(go_around.climb_angle) == doctest::Approx(5.0));
  const Eigen::Vector3d way = go_around.end_in_world - go_around.start_in_world;
  CHECK(std::atan2(way.z(), way.head<2>().norm()) == doctest::Approx(go_around.climb_angle));
  CHECK(HeadingOf(way.head<2>()) == doctest::Approx(approach.heading));
  // The map ends 200 m north of the touchdown, behind the place where the circle's height is met.
  CHECK(std::abs(go_around.end_in_world.y() - 200.0) < 1.0);
  CHECK(go_around.unseen_ratio < kMaxRatioError);
}

TEST_CASE("go-around: it never begins inside the touchdown disc") {
  Aircraft low = Nimble();
  low.safety_margin_m = 0.0;
  const Plan plan = PlanAt(scene::FlatMeadow(400, 400), 0.0, low);
  REQUIRE(plan.approach);
  REQUIRE(plan.approach->go_around);
  CHECK(plan.approach->go_around->no_return_distance ==
        doctest::Approx(low.touchdown_uncertainty_m));
}

TEST_CASE("go-around: a tree line beyond the touchdown moves its begin out as computed") {
  for (const double height : {7.0, 8.0, 10.0, 12.0}) {
    CAPTURE(height);
    Scene scene = scene::FlatMeadow(400, 400);
    scene::AddBlock(scene, {-200, 60}, {200, 62}, height);
    const Plan plan = PlanAt(scene, 0.0);
    REQUIRE(plan.verdict == Verdict::kLandable);
    const Approach& approach = *plan.approach;
    const Slopes slopes = SlopesOf(approach, Nimble().climb_gradient_deg);
    const double ahead = 60.0 - approach.touchdown_in_world.y();
    const double expected =
        (height + Nimble().safety_margin_m - slopes.climb_slope * ahead) / slopes.sum;
    REQUIRE(approach.go_around);
    CHECK(std::abs(approach.go_around->no_return_distance - expected) < kMaxErrorM);
  }
}

TEST_CASE("go-around: the map's tilt asks for more clearance with the distance from touchdown") {
  Scene scene = scene::FlatMeadow(400, 400);
  scene::AddBlock(scene, {-200, 60}, {200, 62}, 8.0);
  scene.map.tilt_sd_deg = 0.3;
  const Plan plan = PlanAt(scene, 0.0);
  REQUIRE(plan.verdict == Verdict::kLandable);
  const Approach& approach = *plan.approach;
  const Slopes slopes = SlopesOf(approach, Nimble().climb_gradient_deg);
  const double ahead = 60.0 - approach.touchdown_in_world.y();
  const double lean = std::tan(RadFromDeg(2.0 * 0.3));  // tilt_sigma deviations
  const double expected =
      (8.0 + Nimble().safety_margin_m + (lean - slopes.climb_slope) * ahead) / slopes.sum;
  REQUIRE(approach.go_around);
  CHECK(std::abs(approach.go_around->no_return_distance - expected) < kMaxErrorM);
}

TEST_CASE("go-around: behind a wall that no climb clears there is none") {
  Scene scene = scene::FlatMeadow(400, 400);
  scene::AddBlock(scene, {-200, 60}, {200, 62}, 60.0);
  const Plan walled = PlanAt(scene, 0.0);
  REQUIRE(walled.verdict == Verdict::kLandable);
  CHECK(walled.approach->strip);
  CHECK_FALSE(walled.approach->go_around);
  // Walls beside the corridor block nothing.
  Scene beside = scene::FlatMeadow(400, 400);
  scene::AddBlock(beside, {12, 60}, {200, 62}, 60.0);
  scene::AddBlock(beside, {-200, 60}, {-12, 62}, 60.0);
  const Plan between = PlanAt(beside, 0.0);
  REQUIRE(between.approach);
  CHECK(between.approach->go_around);
}

TEST_CASE("go-around: a wall behind the place where the climb is at the circle's height blocks") {
  Scene scene = scene::FlatMeadow(600, 400);
  // From the start of the final, 46 m out, the climb is at the circle's height at once.
  scene::AddBlock(scene, {-200, 160}, {200, 162}, 60.0);
  const Plan plan = PlanAt(scene, 0.0);
  REQUIRE(plan.verdict == Verdict::kLandable);
  CHECK_FALSE(plan.approach->go_around);
}

TEST_CASE("go-around: unseen ground ahead blocks nothing, and its share is stated") {
  Scene scene = scene::FlatMeadow(400, 400);
  scene::AddUnseen(scene, {-200, 40}, {200, 200});
  const Plan plan = PlanAt(scene, 0.0);
  REQUIRE(plan.verdict == Verdict::kLandable);
  REQUIRE(plan.approach->go_around);
  const GoAround& go_around = *plan.approach->go_around;
  const Plan seen = PlanAt(scene::FlatMeadow(400, 400), 0.0);
  CHECK(go_around.no_return_distance == seen.approach->go_around->no_return_distance);
  // The climb ends at the height of the circle.
  CHECK(go_around.end_in_world.z() == doctest::Approx(plan.approach->approach_height));
  const double length = (go_around.end_in_world - go_around.start_in_world).head<2>().norm();
  CHECK(std::abs(go_around.unseen_ratio - (go_around.end_in_world.y() - 40.0) / length) <
        kMaxRatioError);
  CHECK(go_around.unseen_ratio > 0.4);
}

TEST_CASE("go-around: what lies off the map is unseen") {
  const Plan plan = PlanAt(scene::FlatMeadow(400, 400), 140.0);
  REQUIRE(plan.verdict == Verdict::kLandable);
  REQUIRE(plan.approach->go_around);
  const GoAround& go_around = *plan.approach->go_around;
  CHECK(go_around.end_in_world.z() == doctest::Approx(plan.approach->approach_height));
  const double length = (go_around.end_in_world - go_around.start_in_world).head<2>().norm();
  CHECK(std::abs(go_around.unseen_ratio - (go_around.end_in_world.y() - 200.0) / length) <
        kMaxRatioError);
  CHECK(go_around.unseen_ratio > 0.2);
}

TEST_CASE("go-around: a rejected path has none, and a plan without explanation does not look") {
  const Scene flat = scene::FlatMeadow(400, 400);
  const PlanRequest request = scene::Request(scene::Box({-1, -1}, {1, 1}), kWind);
  const ApproachPlanner planner(flat.map, flat.hazards, request, Nimble(), scene::OneWay());
  CHECK(planner.PlanFor(kWind).approach->go_around);
  CHECK_FALSE(planner.PlanFor(kWind, Explanation::kNone).approach->go_around);
  Scene blocked = scene::FlatMeadow(400, 400);
  scene::AddBlock(blocked, {-200, -30}, {200, -28}, 20.0);
  const Plan plan = PlanAt(blocked, 0.0);
  REQUIRE(plan.verdict == Verdict::kRejected);
  REQUIRE(plan.approach);
  CHECK_FALSE(plan.approach->go_around);
}

TEST_CASE("go-around: a tail wind that the final allows for flattens the climb") {
  const Aircraft aircraft = Nimble();
  constexpr double kTailwindMps = 5.5;
  Approach approach;
  approach.approach_height = aircraft.approach_height_m;
  approach.approach_distance = ApproachDistance(aircraft, 4.0);
  const double climb = RadFromDeg(aircraft.climb_gradient_deg);
  CHECK(ClimbSlope(approach, aircraft) == doctest::Approx(std::tan(climb)));
  approach.approach_distance = DownwindApproachDistance(aircraft, kTailwindMps);
  const double airspeed = aircraft.landing_airspeed_mps;
  CHECK(ClimbSlope(approach, aircraft) ==
        doctest::Approx(airspeed * std::sin(climb) / (airspeed * std::cos(climb) + kTailwindMps)));
}

TEST_CASE("go-around: in unknown wind it clears in calm and in the tail wind") {
  constexpr double kTreesM = 8.0, kAwayM = 79.0, kTailwindMps = 5.5;
  Scene scene = scene::FlatMeadow(400, 400);
  for (const double side : {-1.0, 1.0}) {
    const double near = std::min(kAwayM * side, (kAwayM + 2.0) * side), far = near + 2.0;
    scene::AddBlock(scene, {-200, near}, {200, far}, kTreesM);
    scene::AddBlock(scene, {near, -200}, {far, 200}, kTreesM);
  }
  // Steep, so that final and circles fit between the tree lines.
  Aircraft aircraft = Nimble();
  aircraft.flight_path_angle_deg = 20.0;
  aircraft.max_bank_deg = 60.0;
  const PlanRequest request = scene::Request(scene::Box({-1, -1}, {1, 1}), std::nullopt);
  const Plan plan = scene::PlanOn(scene, request, aircraft, scene::OneWay());
  REQUIRE(plan.verdict == Verdict::kUnverified);
  const Approach& flown = *plan.approach;
  REQUIRE(flown.go_around);
  CHECK(DegFromRad(flown.go_around->climb_angle) == doctest::Approx(5.0));
  // The tail wind decides: final and climb are flatter in it.
  Approach downwind = flown;
  downwind.approach_distance = DownwindApproachDistance(aircraft, kTailwindMps);
  const double final_slope = downwind.approach_height / downwind.approach_distance;
  const double climb_slope = ClimbSlope(downwind, aircraft);
  const Eigen::Vector2d forward = DirectionOf(flown.heading).cwiseAbs();
  const double ahead = kAwayM / forward.maxCoeff();
  const double needed =
      (kTreesM + aircraft.safety_margin_m - climb_slope * ahead) / (final_slope + climb_slope);
  // The corridor's corner meets the trees up to 8 m * tan(45 deg) earlier.
  CHECK(flown.go_around->no_return_distance > needed - kMaxErrorM);
  CHECK(flown.go_around->no_return_distance < needed + 2.0);
}

TEST_CASE("go-around: a plan of one region sees as far as a planner of the whole map") {
  Scene scene = scene::FlatMeadow(900, 400);
  scene::AddBlock(scene, {-200, 400}, {200, 402}, 40.0);
  const PlanRequest request = scene::Request(scene::Box({-1, -1}, {1, 1}), kWind);
  const Plan of_region = scene::PlanOn(scene, request, Nimble(), scene::OneWay());
  const ApproachPlanner planner(scene.map, scene.hazards, request, Nimble(), scene::OneWay());
  const Plan of_map = planner.PlanFor(kWind);
  REQUIRE(of_region.approach->go_around);
  REQUIRE(of_map.approach->go_around);
  CHECK(of_region.approach->go_around->no_return_distance ==
        of_map.approach->go_around->no_return_distance);
  CHECK(of_region.approach->go_around->no_return_distance >
        PlanAt(scene::FlatMeadow(900, 400), 0.0).approach->go_around->no_return_distance);
  CHECK(of_region.approach->go_around->unseen_ratio ==
        doctest::Approx(of_map.approach->go_around->unseen_ratio));
}

// Blocks north of the touchdown, over which a climb leads.
Scene RandomScene(std::mt19937& random) {
  const auto uniform = [&random](double low, double high) {
    return low + (high - low) * (random() / 4294967296.0);
  };
  Scene scene = scene::FlatMeadow(300, 120);
  const int num_blocks = 1 + static_cast<int>(uniform(0, 8));
  for (int i = 0; i < num_blocks; ++i) {
    const Eigen::Vector2d low(uniform(-40, 30), uniform(45, 140));
    scene::AddBlock(
        scene, low, low + Eigen::Vector2d(uniform(1, 20), uniform(1, 10)), uniform(2, 22));
  }
  return scene;
}

// The least spare height of a climb over all cells of its corridor, by the map's cells.
double LeastSpareHeight(const Scene& scene,
                        const Approach& approach,
                        double distance,
                        double climb_slope,
                        double half_width) {
  const double final_slope = approach.approach_height / approach.approach_distance;
  const Eigen::Vector2d forward = DirectionOf(approach.heading);
  double least = HUGE_VAL;
  for (int row = 0; row < scene.map.grid.num_rows; ++row) {
    for (int col = 0; col < scene.map.grid.num_cols; ++col) {
      const Eigen::Vector2d place =
          scene.CellCenter(row, col) - approach.touchdown_in_world.head<2>();
      const double along = place.dot(forward);
      const double across = place.x() * forward.y() - place.y() * forward.x();
      if (along < -distance || std::abs(across) > half_width) continue;
      const double height = final_slope * distance + climb_slope * (along + distance);
      least = std::min(least, height - scene.map.upper(row, col));
    }
  }
  return least;
}

TEST_CASE("go-around: over random ground it clears every cell, and a steeper climb begins later") {
  constexpr double kMaxDeficitM = 0.15;  // half a cell of final and climb
  constexpr double kPositionMarginM = 3.0;
  std::mt19937 random(31);
  int num_found = 0, num_none = 0, num_moved = 0;
  for (int trial = 0; trial < 60; ++trial) {
    CAPTURE(trial);
    const Scene scene = RandomScene(random);
    std::optional<double> last;
    for (const double climb_deg : {1.0, 3.0, 5.0, 8.0, 12.0, 20.0}) {
      CAPTURE(climb_deg);
      Aircraft aircraft = Nimble();
      aircraft.climb_gradient_deg = climb_deg;
      const Plan plan = PlanAt(scene, 0.0, aircraft);
      REQUIRE(plan.verdict == Verdict::kLandable);
      const Approach& approach = *plan.approach;
      if (!approach.go_around) {
        // A flatter climb cleared no more.
        REQUIRE_FALSE(last);
        ++num_none;
        continue;
      }
      const double distance = approach.go_around->no_return_distance;
      if (last) REQUIRE(distance <= *last);
      num_moved += last && distance < *last;
      last = distance;
      ++num_found;
      const double climb_slope = std::tan(RadFromDeg(climb_deg));
      const double half_width = aircraft.path_half_width_m + kPositionMarginM;
      CHECK(LeastSpareHeight(scene, approach, distance, climb_slope, half_width) >=
            aircraft.safety_margin_m - kMaxDeficitM);
      // Two metres nearer it would not clear, or it would begin too low.
      const double nearest =
          aircraft.safety_margin_m * approach.approach_distance / approach.approach_height;
      const double wide = half_width + 2.0;
      if (distance < nearest + 2.0) continue;
      CHECK(LeastSpareHeight(scene, approach, distance - 2.0, climb_slope, wide) <
            aircraft.safety_margin_m);
    }
  }
  CHECK(num_found > 100);
  CHECK(num_none > 20);
  CHECK(num_moved > 50);
}

}  // namespace
}  // namespace freelsd
