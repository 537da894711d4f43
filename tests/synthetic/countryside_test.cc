#include <doctest/doctest.h>

#include "tests/synthetic/truth.h"
#include "tests/synthetic/world.h"

namespace freelsd {
namespace {

WorldOptions Plane() {
  WorldOptions options;
  options.size_m = 200.0;
  options.cell_size_m = 0.25;
  return options;
}

TEST_CASE("things: none of them is landable ground, however small") {
  const Aircraft aircraft = AircraftProfile("small").value();
  World world = MakeMeadowPlane(Plane());
  world.Put(Block{.center = {-40.0, 0.0}, .length_m = 2.1, .width_m = 0.8, .height_m = 1.4});
  world.Put(Boulder{.center = {-20.0, 0.0}});
  world.Dig(Ditch{.start = {0.0, -20.0}, .end = {0.0, 20.0}});
  world.Build(Fence{.start = {20.0, -20.0}, .end = {20.0, 20.0}});
  world.Plant(Tree{.center = {40.0, 0.0}, .is_leafless = true});
  for (const double x : {-40.0, -20.0, 0.0, 20.0, 40.0}) {
    CHECK(GroundFaultAt(world, aircraft, x, 0.0, 1.0) == GroundFault::kCover);
    CHECK(GroundFaultAt(world, aircraft, x + 10.0, 0.0, 1.0) == GroundFault::kNone);
  }
  CHECK(world.SurfaceHeight(-40.0, 0.0) == doctest::Approx(1.4));
  CHECK(world.SurfaceHeight(0.0, 0.0) < -0.5);
}

TEST_CASE("things: a wire blocks the final, yet nothing of it can be seen") {
  const Aircraft aircraft = AircraftProfile("small").value();
  World world = MakeMeadowPlane(Plane());  // wind blows east: the final comes from there
  const double free = FinalReserve(world, aircraft, {0.0, 0.0});
  CHECK(free > 0.0);
  world.Build(PowerLine{.start = {18.0, -100.0}, .end = {18.0, 100.0}});
  CHECK(world.IsWireAt(18.0, 3.0));
  CHECK(world.SurfaceHeight(18.0, 3.0) < 0.5);
  CHECK(FinalReserve(world, aircraft, {0.0, 0.0}) < 0.0);
  CHECK_FALSE(world.IsWireAt(30.0, 3.0));
}

TEST_CASE("things: most of a leafless crown is seen through, and its top is still there") {
  World world = MakeMeadowPlane(Plane());
  world.Plant(Tree{.radius_m = 5.0, .height_m = 12.0, .is_leafless = true});
  int num_cells = 0, num_high = 0;
  double highest = 0.0;
  for (double x = -4.0; x <= 4.0; x += 0.25) {
    for (double y = -4.0; y <= 4.0; y += 0.25) {
      if (world.CoverAt(x, y) != Cover::kBareTree) continue;
      const double height = world.SurfaceHeight(x, y);
      ++num_cells;
      num_high += height > 2.0;
      highest = std::max(highest, height);
    }
  }
  CHECK(num_cells > 500);
  CHECK(num_high < 0.5 * num_cells);
  CHECK(highest > 10.0);
}

TEST_CASE("movers: to and fro along their heading, seen in the moment and not in the world") {
  World world = MakeMeadowPlane(Plane());
  world.Paint();
  world.Light();
  Mover mover;
  mover.block.heading = 0.5 * kPi;  // east
  mover.speed_mps = 5.0;
  mover.way_m = 20.0;
  CHECK(mover.PlaceAt(2.0).x() == doctest::Approx(10.0));
  CHECK(mover.PlaceAt(6.0).x() == doctest::Approx(10.0));  // on its way back
  CHECK(mover.PlaceAt(8.0).norm() == doctest::Approx(0.0));
  world.movers.push_back(mover);
  const World moment = world.At(2.0);
  CHECK(moment.CoverAt(10.0, 0.0) == Cover::kVehicle);
  CHECK(moment.SurfaceHeight(10.0, 0.0) > 1.0);
  CHECK(moment.CoverAt(0.0, 0.0) == Cover::kMeadow);
  CHECK(world.CoverAt(10.0, 0.0) == Cover::kMeadow);
  CHECK(world.SurfaceHeight(10.0, 0.0) < 1.0);
  const int row = world.CellIndex(0.0), col = world.CellIndex(10.0);
  CHECK(moment.radiance(row, col) != world.radiance(row, col));
}

TEST_CASE("countryside: same seed, same world, it holds good fields and traps") {
  WorldOptions options;
  options.size_m = 400.0;
  options.cell_size_m = 0.5;
  const World world = MakeCountryside(options);
  const World again = MakeCountryside(options);
  CHECK(cv::norm(world.radiance, again.radiance, cv::NORM_INF) == 0.0);
  CHECK(cv::norm(world.surface, again.surface, cv::NORM_INF) == 0.0);
  int num_landable = 0, num_not = 0;
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    options.seed = seed;
    for (const TrueField& field :
         JudgeFields(MakeCountryside(options), AircraftProfile("small").value())) {
      ++(field.is_landable ? num_landable : num_not);
    }
  }
  CHECK(num_landable > 0);
  CHECK(num_not > 0);
}

}  // namespace
}  // namespace freelsd
