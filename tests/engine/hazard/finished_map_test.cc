// How a finished map is rounded, and cut.
#include <cmath>
#include <random>

#include <doctest/doctest.h>

#include "engine/hazard/hazard.h"

namespace freelsd {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

cv::Mat1f Random(std::mt19937& random, float low, float high, double unknown_ratio) {
  cv::Mat1f raster(30, 40);
  std::uniform_real_distribution<float> value(low, high);
  std::bernoulli_distribution is_unknown(unknown_ratio);
  for (float& each : raster) each = is_unknown(random) ? kNaN : value(random);
  return raster;
}

AssessedMap RandomMap(unsigned seed) {
  std::mt19937 random(seed);
  AssessedMap made;
  made.map.grid = made.layers.grid = {{-20.0, 15.0}, 1.0, 30, 40};
  made.map.elevation = Random(random, -40.0f, 90.0f, 0.1);
  made.map.upper = made.map.elevation + Random(random, 0.0f, 20.0f, 0.0);
  made.map.standard_deviation = Random(random, 0.0f, 2.0f, 0.1);
  made.map.num_points = Random(random, 3.0f, 300.0f, 0.1);
  made.layers.slope = Random(random, 0.0f, 1.5f, 0.1);
  made.layers.roughness = Random(random, 0.0f, 5.0f, 0.1);
  made.layers.grass = Random(random, 0.0f, 1.0f, 0.1);
  made.layers.hazard = cv::Mat1b(30, 40, uchar{kUnseen});
  made.layers.distance = cv::Mat1f::zeros(30, 40);
  return made;
}

bool IsSame(const cv::Mat1f& a, const cv::Mat1f& b) {
  return std::equal(a.begin(), a.end(), b.begin(), [](float x, float y) {
    return x == y || (std::isnan(x) && std::isnan(y));
  });
}

TEST_CASE(
    "finished map: no value is rounded to the safe side, and rounding twice changes nothing") {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const AssessedMap made = RandomMap(seed);
    const AssessedMap rounded = Rounded(made.map, made.layers);
    for (int row = 0; row < 30; ++row) {
      for (int col = 0; col < 40; ++col) {
        if (std::isnan(made.map.elevation(row, col))) {
          CHECK(std::isnan(rounded.map.elevation(row, col)));
          continue;
        }
        CHECK(std::abs(rounded.map.elevation(row, col) - made.map.elevation(row, col)) <=
              0.5f * MapSteps::kHeightM);
        CHECK(rounded.map.upper(row, col) >= made.map.upper(row, col));
        CHECK(rounded.map.upper(row, col) < made.map.upper(row, col) + 1.01f * MapSteps::kHeightM);
      }
    }
    CHECK(cv::countNonZero(rounded.map.standard_deviation < made.map.standard_deviation) == 0);
    CHECK(cv::countNonZero(rounded.map.num_points > made.map.num_points) == 0);
    CHECK(cv::countNonZero(rounded.layers.slope < made.layers.slope) == 0);
    CHECK(cv::countNonZero(rounded.layers.roughness < made.layers.roughness) == 0);
    CHECK(cv::countNonZero(rounded.layers.grass > made.layers.grass) == 0);
    const AssessedMap twice = Rounded(rounded.map, rounded.layers);
    CHECK(IsSame(twice.map.elevation, rounded.map.elevation));
    CHECK(IsSame(twice.map.upper, rounded.map.upper));
    CHECK(IsSame(twice.map.standard_deviation, rounded.map.standard_deviation));
    CHECK(IsSame(twice.layers.slope, rounded.layers.slope));
    CHECK(IsSame(twice.layers.roughness, rounded.layers.roughness));
  }
}

TEST_CASE("finished map: what needs too many steps is unknown, and an object stays an object") {
  AssessedMap made = RandomMap(1);
  made.map.elevation(0, 0) = 10.0f;
  made.map.upper(0, 0) = 5000.0f;
  made.map.standard_deviation(0, 0) = 600.0f;
  made.layers.roughness(0, 0) = 200.0f;
  const AssessedMap rounded = Rounded(made.map, made.layers);
  CHECK(rounded.map.upper(0, 0) > 500.0f);
  CHECK(std::isnan(rounded.map.standard_deviation(0, 0)));
  CHECK(std::isnan(rounded.layers.roughness(0, 0)));
}

TEST_CASE("finished map: a window has the same values at the same places") {
  const AssessedMap made = RandomMap(3);
  const AssessedMap window = WindowOf(made.map, made.layers, {5, 7, 11, 13});
  CHECK(window.map.grid == window.layers.grid);
  CHECK(window.map.grid.num_rows == 13);
  CHECK(window.map.grid.CellCenter(0, 0) == made.map.grid.CellCenter(7, 5));
  CHECK(IsSame(window.map.elevation, made.map.elevation({5, 7, 11, 13})));
  CHECK(IsSame(window.layers.grass, made.layers.grass({5, 7, 11, 13})));
  CHECK(WindowOf(made.map, made.layers, {}).map.elevation.empty());
}

}  // namespace
}  // namespace freelsd
