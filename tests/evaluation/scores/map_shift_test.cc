#include "tests/evaluation/scores/map_shift.h"

#include <cmath>

#include <doctest/doctest.h>

namespace freelsd {
namespace {

constexpr int kSizeM = 200;
// Steps of the search.
constexpr double kToleranceM = 0.75;

// Hedges and trees here and there.
World MeadowWithThings() {
  WorldOptions options;
  options.size_m = kSizeM;
  options.cell_size_m = 0.5;
  World world = MakeMeadowPlane(options);
  for (int i = -3; i <= 3; ++i) {
    world.Plant(Tree{.center = {25.0 * i, 20.0 * std::sin(2.0 * i) + 10.0 * i}});
    world.Plant(Hedge{.start = {25.0 * i, -60.0}, .end = {25.0 * i + 15.0, -50.0 + 5.0 * i}});
  }
  return world;
}

// What stands in the world, at another place: by `shift_of` a place, and on a tilted plane.
template <typename ShiftOf>
ElevationMap MapOf(const World& world, const ErrorPlane& height, ShiftOf shift_of) {
  ElevationMap map;
  map.grid = {{-0.5 * kSizeM, 0.5 * kSizeM}, 1.0, kSizeM, kSizeM};
  map.elevation = cv::Mat1f(kSizeM, kSizeM, 0.0f);
  map.upper = map.elevation.clone();
  for (int row = 0; row < kSizeM; ++row) {
    for (int col = 0; col < kSizeM; ++col) {
      const Eigen::Vector2d place = map.grid.CellCenter(row, col);
      const Eigen::Vector2d truly = place - shift_of(place);
      map.upper(row, col) =
          static_cast<float>(world.SurfaceHeight(truly.x(), truly.y()) + height.At(truly));
    }
  }
  return map;
}

TEST_CASE("map shift: the shift of a whole map is found from an estimate that is metres off") {
  const World world = MeadowWithThings();
  const TruthMap truth = MakeTruthMap(world, AircraftProfile("small").value());
  const ErrorPlane height{3.0, {0.01, 0.0}};
  const Eigen::Vector2d shift(3.0, -5.0);
  const ElevationMap map =
      MapOf(world, height, [](const Eigen::Vector2d&) { return Eigen::Vector2d(3.0, -5.0); });
  const MapOffset offset = OffsetOfMap(world, truth, map, height, {-1.0, -1.0});
  CHECK((offset.shift - shift).norm() < kToleranceM);
  CHECK((offset.ShiftAt({10.0, 10.0}) - shift).norm() < kToleranceM);
}

TEST_CASE("map shift: a part of the map has its own shift") {
  const World world = MeadowWithThings();
  const TruthMap truth = MakeTruthMap(world, AircraftProfile("small").value());
  const Eigen::Vector2d west(2.0, 0.0), east(0.0, 2.0);
  const ElevationMap map =
      MapOf(world, {}, [&](const Eigen::Vector2d& place) { return place.x() < 0.0 ? west : east; });
  const MapOffset offset = OffsetOfMap(world, truth, map, {}, {1.0, 1.0});
  CHECK((offset.ShiftAt({-75.0, -25.0}) - west).norm() < kToleranceM);
  CHECK((offset.ShiftAt({75.0, -25.0}) - east).norm() < kToleranceM);
}

TEST_CASE("map shift: without a map, or on bare ground, the cameras tell") {
  WorldOptions options;
  options.size_m = kSizeM;
  options.cell_size_m = 0.5;
  const World bare = MakeMeadowPlane(options);
  const TruthMap truth = MakeTruthMap(bare, AircraftProfile("small").value());
  const Eigen::Vector2d cameras(0.7, -0.4);
  CHECK(OffsetOfMap(bare, truth, ElevationMap{}, {}, cameras).shift == cameras);
  const ElevationMap map =
      MapOf(bare, {}, [](const Eigen::Vector2d&) { return Eigen::Vector2d(2.0, 2.0); });
  CHECK(OffsetOfMap(bare, truth, map, {}, cameras).ShiftAt({0.0, 0.0}) == cameras);
}

}  // namespace
}  // namespace freelsd
