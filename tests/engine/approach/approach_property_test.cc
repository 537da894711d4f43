#include <random>

#include <doctest/doctest.h>

#include "engine/approach/approach.h"
#include "tests/engine/approach/scene.h"

namespace freelsd {
namespace {

using scene::Scene;

constexpr int kNumMaps = 250;
constexpr int kSizeCells = 90;
constexpr double kHalfM = 0.5 * kSizeCells;

// In 2 m/s: a final of 26 m and circles of 6 m radius.
Aircraft Tiny() {
  Aircraft aircraft;
  aircraft.landing_airspeed_mps = 6.0;
  aircraft.flight_path_angle_deg = 12.0;
  aircraft.max_bank_deg = 45.0;
  aircraft.approach_height_m = 8.0;
  aircraft.touchdown_uncertainty_m = 3.0;
  aircraft.path_half_width_m = 2.0;
  aircraft.ground_roll_m = 6.0;
  aircraft.min_area_m2 = 100.0;
  return aircraft;
}

// Every safe place is tried, so that the search itself cannot hide a difference.
ApproachOptions Exhaustive() {
  ApproachOptions options;
  options.candidate_spacing_m = 0.0;
  options.max_num_candidates = 100000;
  options.heading_step_deg = 60.0;
  options.unknown_wind_mps = 1.0;
  return options;
}

class World {
 public:
  explicit World(unsigned seed) : random_(seed) {}

  double Uniform(double low, double high) {
    // Own mapping: the library's distributions differ between implementations.
    return low + (high - low) * (random_() / 4294967296.0);
  }
  Eigen::Vector2d Place() { return {Uniform(-kHalfM, kHalfM), Uniform(-kHalfM, kHalfM)}; }

  void AddBlocks(Scene& scene, int count) {
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2d low = Place();
      scene::AddBlock(
          scene, low, low + Eigen::Vector2d(Uniform(1, 12), Uniform(1, 12)), Uniform(0, 15));
    }
  }
  void AddGaps(Scene& scene, int count) {
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2d low = Place();
      scene::AddUnseen(scene, low, low + Eigen::Vector2d(Uniform(1, 12), Uniform(1, 12)));
    }
  }
  std::optional<Eigen::Vector2d> Wind() {
    const double kind = Uniform(0, 1);
    if (kind < 0.1) return std::nullopt;
    if (kind < 0.2) return Eigen::Vector2d(0.0, 0.1);
    return 2.0 * DirectionOf(Uniform(0, 2 * kPi));
  }

 private:
  std::mt19937 random_;
};

Scene RandomScene(World& world) {
  const double east = world.Uniform(-0.03, 0.03), north = world.Uniform(-0.03, 0.03);
  Scene scene = scene::Meadow(kSizeCells, kSizeCells, 1.0, [&](const Eigen::Vector2d& place) {
    return east * place.x() + north * place.y();
  });
  world.AddBlocks(scene, static_cast<int>(world.Uniform(4, 18)));
  if (world.Uniform(0, 1) < 0.5) world.AddGaps(scene, static_cast<int>(world.Uniform(0, 6)));
  return scene;
}

Aircraft Tightened(Aircraft aircraft, World& world) {
  switch (static_cast<int>(world.Uniform(0, 5))) {
    case 0:
      aircraft.touchdown_uncertainty_m += world.Uniform(0, 3);
      break;
    case 1:
      aircraft.safety_margin_m += world.Uniform(0, 3);
      break;
    case 2:
      aircraft.path_half_width_m += world.Uniform(0, 4);
      break;
    case 3:
      aircraft.ground_roll_m += world.Uniform(0, 20);
      break;
    default:
      aircraft.min_area_m2 *= world.Uniform(1, 40);
  }
  return aircraft;
}

TEST_CASE("approach: knowing less, more hazard or tighter limits never improve the verdict") {
  World world(7);
  int num_by_verdict[3] = {};
  int num_worse = 0;
  for (int i = 0; i < kNumMaps; ++i) {
    const Scene before = RandomScene(world);
    Scene after = before;
    for (cv::Mat1f* layer : {&after.map.elevation,
                             &after.map.upper,
                             &after.map.standard_deviation,
                             &after.hazards.slope,
                             &after.hazards.roughness,
                             &after.hazards.grass,
                             &after.hazards.distance}) {
      *layer = layer->clone();
    }
    after.hazards.hazard = after.hazards.hazard.clone();
    Aircraft aircraft_after = Tiny();
    const int kind = static_cast<int>(world.Uniform(0, 3));
    if (kind == 0) world.AddGaps(after, 4 + static_cast<int>(world.Uniform(0, 12)));
    if (kind == 1) world.AddBlocks(after, 4 + static_cast<int>(world.Uniform(0, 12)));
    if (kind == 2) aircraft_after = Tightened(aircraft_after, world);
    const PlanRequest request = scene::Request(scene::Box({-5, -5}, {5, 5}), world.Wind());
    const Plan plan = PlanApproach(before.map, before.hazards, request, Tiny(), Exhaustive());
    const Plan other =
        PlanApproach(after.map, after.hazards, request, aircraft_after, Exhaustive());
    CAPTURE(i);
    CAPTURE(kind);
    // Unseen ground can hide what blocks, so a rejected place may become unverified, never
    // landable.
    if (plan.verdict != Verdict::kLandable) CHECK(other.verdict != Verdict::kLandable);
    if (kind != 0 && plan.verdict == Verdict::kRejected) CHECK(other.verdict == plan.verdict);
    ++num_by_verdict[static_cast<int>(plan.verdict)];
    num_worse += other.verdict > plan.verdict;
  }
  // The maps must tell something: all verdicts occur, and changes matter.
  CHECK(num_by_verdict[0] > kNumMaps / 10);
  CHECK(num_by_verdict[1] > kNumMaps / 20);
  CHECK(num_by_verdict[2] > kNumMaps / 10);
  CHECK(num_worse > kNumMaps / 10);
}

// Distance to touchdown of the nearest cell below the final that is not free. Nearer ground needs
// no clearance.
double FirstNotFree(const Plan& plan, const Scene& scene, const Aircraft& aircraft) {
  const Approach& approach = *plan.approach;
  const Eigen::Vector2d forward = DirectionOf(approach.heading);
  double nearest = approach.approach_distance;
  for (int row = 0; row < kSizeCells; ++row) {
    for (int col = 0; col < kSizeCells; ++col) {
      if (scene.hazards.hazard(row, col) == kFree) continue;
      const Eigen::Vector2d before =
          approach.touchdown_in_world.head<2>() - scene.CellCenter(row, col);
      const double along = before.dot(forward);
      const double across = std::abs(forward.x() * before.y() - forward.y() * before.x());
      const double reach = aircraft.path_half_width_m + scene.map.grid.cell_size_m;
      if (across > reach || along < aircraft.touchdown_uncertainty_m) continue;
      nearest = std::min(nearest, along);
    }
  }
  return nearest - 2.0 * scene.map.grid.cell_size_m;
}

// Independent of the planner's own sampling: every cell is compared with the path.
void CheckNothingInTheWay(const Plan& plan, const Scene& scene, const Aircraft& aircraft) {
  const Approach& approach = *plan.approach;
  const Eigen::Vector2d forward = DirectionOf(approach.heading);
  const Eigen::Vector2d touchdown = approach.touchdown_in_world.head<2>();
  const double first_not_free = FirstNotFree(plan, scene, aircraft);
  for (int row = 0; row < kSizeCells; ++row) {
    for (int col = 0; col < kSizeCells; ++col) {
      const Eigen::Vector2d place = scene.CellCenter(row, col);
      const double along = (touchdown - place).dot(forward);
      const double across =
          std::abs(forward.x() * (place - touchdown).y() - forward.y() * (place - touchdown).x());
      const float height = scene.map.upper(row, col);
      const bool is_below_final = across <= aircraft.path_half_width_m &&
                                  along >= aircraft.touchdown_uncertainty_m &&
                                  along > first_not_free && along <= approach.approach_distance;
      if (is_below_final) {
        const double path = approach.approach_height * along / approach.approach_distance;
        const double wanted = std::min(aircraft.safety_margin_m, 0.5 * path);
        // A step of half a cell along the path.
        const double tolerance = 0.5 * approach.approach_height / approach.approach_distance;
        CHECK(approach.touchdown_in_world.z() + path - height >= wanted - tolerance);
      }
      const double off_circle = std::abs(
          (place - approach.loiter_center_in_world.head<2>()).norm() - approach.loiter_radius);
      if (off_circle <= aircraft.path_half_width_m) {
        CHECK(approach.loiter_center_in_world.z() - height >= aircraft.safety_margin_m - 1e-6);
      }
      const bool is_in_roll =
          across <= aircraft.path_half_width_m && along <= 0.0 && -along <= aircraft.ground_roll_m;
      const bool is_in_disc = (place - touchdown).norm() <= aircraft.touchdown_uncertainty_m;
      if (is_in_roll || is_in_disc) CHECK(scene.hazards.hazard(row, col) == kFree);
    }
  }
}

TEST_CASE("approach: nothing seen or unseen stands in the way of a landable plan") {
  World world(11);
  int num_landable = 0;
  for (int i = 0; i < kNumMaps; ++i) {
    const Scene scene = RandomScene(world);
    const Eigen::Vector2d wind = 2.0 * DirectionOf(world.Uniform(0, 2 * kPi));
    const Plan plan = PlanApproach(scene.map,
                                   scene.hazards,
                                   scene::Request(scene::Box({-5, -5}, {5, 5}), wind),
                                   Tiny(),
                                   ApproachOptions{});
    CHECK(plan.score >= 0.0);
    CHECK(plan.score <= 1.0);
    if (plan.verdict != Verdict::kLandable) continue;
    ++num_landable;
    CheckNothingInTheWay(plan, scene, Tiny());
  }
  CHECK(num_landable > kNumMaps / 10);
}

}  // namespace
}  // namespace freelsd
