#include "tests/evaluation/scores/things.h"

#include <doctest/doctest.h>

namespace freelsd {
namespace {

constexpr int kSizeM = 60;
// Found, unknown, hazard, missed.
using Fates = std::array<int64_t, kNumThingFates>;

// All of it is photographed.
Scenario MeadowWithCar(const Eigen::Vector2d& place) {
  WorldOptions options;
  options.size_m = kSizeM;
  options.cell_size_m = 0.2;
  Scenario scenario;
  scenario.world = MakeMeadowPlane(options);
  scenario.world.Put(Block{.center = place, .height_m = 1.4});
  scenario.seen = cv::Mat1b(kSizeM, kSizeM, uint8_t{255});
  return scenario;
}

struct HandMadeMap {
  ElevationMap map;
  HazardLayers layers;
};

// Flat and free.
HandMadeMap FlatMap() {
  HandMadeMap made;
  made.map.grid = {{-0.5 * kSizeM, 0.5 * kSizeM}, 1.0, kSizeM, kSizeM};
  made.map.elevation = cv::Mat1f::zeros(kSizeM, kSizeM);
  made.map.upper = cv::Mat1f::zeros(kSizeM, kSizeM);
  made.map.standard_deviation = cv::Mat1f(kSizeM, kSizeM, 0.1f);
  made.layers.grid = made.map.grid;
  made.layers.hazard = cv::Mat1b(kSizeM, kSizeM, uint8_t{kFree});
  return made;
}

// Cells of the map around a place, wide enough for the car.
cv::Rect CellsAt(const HandMadeMap& made, const Eigen::Vector2d& place) {
  const cv::Point cell = made.map.grid.CellAt(place).value();
  return {cell.x - 3, cell.y - 3, 7, 7};
}

Fates FatesOf(const Scenario& scenario, const HandMadeMap& made, const MapOffset& offset = {}) {
  const ThingCounts counts = ScoreThings(scenario, made.map, made.layers, offset).counts;
  REQUIRE(counts.size() == 1);
  CHECK(counts.begin()->first == "vehicle/1-3/0.5-1.5");
  return counts.begin()->second;
}

const Eigen::Vector2d kPlace(5.3, -7.1);

TEST_CASE("things: a car of known height is found, missed, a hazard or unknown as the map says") {
  const Scenario scenario = MeadowWithCar(kPlace);
  HandMadeMap made = FlatMap();
  CHECK(FatesOf(scenario, made) == Fates{0, 0, 0, 1});
  const ThingScores scores = ScoreThings(scenario, made.map, made.layers, {});
  CHECK((scores.missed.at(0).second - kPlace).norm() < 0.2);
  made.map.upper(CellsAt(made, kPlace)) = 1.2f;
  CHECK(FatesOf(scenario, made) == Fates{1, 0, 0, 0});
  // A metre of error is as much as the car: it is not found.
  made.map.upper(CellsAt(made, kPlace)) = 0.5f;
  CHECK(FatesOf(scenario, made) == Fates{0, 0, 0, 1});
  made.layers.hazard(CellsAt(made, kPlace)) = uint8_t{kHazard};
  CHECK(FatesOf(scenario, made) == Fates{0, 0, 1, 0});
  made.layers.hazard(CellsAt(made, kPlace)) = uint8_t{kUnseen};
  CHECK(FatesOf(scenario, made) == Fates{0, 1, 0, 0});
  made.layers.hazard(CellsAt(made, kPlace)) = uint8_t{kFree};
  made.map.standard_deviation(CellsAt(made, kPlace)) = 2.0f;
  CHECK(FatesOf(scenario, made) == Fates{0, 1, 0, 0});
}

TEST_CASE("things: what was not photographed does not count") {
  Scenario scenario = MeadowWithCar(kPlace);
  const HandMadeMap made = FlatMap();
  scenario.seen = cv::Mat1b(kSizeM, kSizeM, uint8_t{0});
  CHECK(ScoreThings(scenario, made.map, made.layers, {}).counts.empty());
}

TEST_CASE("things: shift and tilt of the whole map are no error of a thing") {
  const Scenario scenario = MeadowWithCar(kPlace);
  const MapOffset offset{{12.0, 3.0}, {3.0, {0.02, -0.01}}};
  HandMadeMap made = FlatMap();
  for (int row = 0; row < kSizeM; ++row) {
    for (int col = 0; col < kSizeM; ++col) {
      const Eigen::Vector2d place = made.map.grid.CellCenter(row, col) - offset.shift;
      made.map.upper(row, col) = static_cast<float>(offset.height.At(place));
    }
  }
  CHECK(FatesOf(scenario, made, offset) == Fates{0, 0, 0, 1});
  made.map.upper(CellsAt(made, kPlace + offset.shift)) += 1.4f;
  CHECK(FatesOf(scenario, made, offset) == Fates{1, 0, 0, 0});
  // Without the offset the car is sought where it is not.
  CHECK(FatesOf(scenario, made, {{0.0, 0.0}, offset.height}) == Fates{0, 0, 0, 1});
}

TEST_CASE("things: kind, width and height name a class, and a fence is one thing") {
  WorldOptions options;
  options.size_m = kSizeM;
  options.cell_size_m = 0.2;
  World world = MakeMeadowPlane(options);
  world.Put(Boulder{.center = {-20.0, 0.0}, .radius_m = 0.4, .height_m = 0.45});
  world.Put(Boulder{.center = {-10.0, 0.0}, .radius_m = 0.4, .height_m = 0.2});
  world.Plant(Hedge{.start = {0.0, -20.0}, .end = {3.0, 20.0}});
  world.Build(Fence{.start = {15.0, -20.0}, .end = {15.0, 20.0}});
  world.Plant(Tree{.center = {24.0, 0.0}, .is_leafless = true});
  std::map<std::string, int> classes;
  for (const Thing& thing : ThingsWithin(world, FlatMap().map.grid)) ++classes[thing.ClassName()];
  CHECK(classes == std::map<std::string, int>{{"boulder/<1/<0.5", 1},
                                              {"hedge/1-3/>1.5", 1},
                                              {"fence/<1/0.5-1.5", 1},
                                              {"bare tree/>3/>1.5", 1}});
  // Beyond the map there is nothing to be found.
  Grid western = FlatMap().map.grid;
  western.num_cols = kSizeM / 4;
  CHECK(ThingsWithin(world, western).size() == 1);
}

}  // namespace
}  // namespace freelsd
