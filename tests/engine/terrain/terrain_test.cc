#include "engine/terrain/terrain.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <stdexcept>

#include <doctest/doctest.h>

#include "tests/engine/refusal.h"

namespace freelsd {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

using Surface = std::function<double(double east, double north)>;

Grid Square(int num_cells) {
  return GridAround(
      {0.0, 0.0}, {static_cast<double>(num_cells), static_cast<double>(num_cells)}, 1.0);
}

DensePoint PointAt(double east, double north, double up) {
  return {Eigen::Vector3d(east, north, up).cast<float>(), 0.1f};
}

Points Sample(const Surface& surface, const Grid& grid, int num_points, double noise_m, int seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  std::normal_distribution<double> noise(0.0, 1.0);
  Points points;
  for (int i = 0; i < num_points; ++i) {
    const double east = grid.north_west_in_world.x() + share(random) * grid.num_cols;
    const double north = grid.north_west_in_world.y() - share(random) * grid.num_rows;
    points.push_back(PointAt(east, north, surface(east, north) + noise_m * noise(random)));
  }
  return points;
}

ElevationMap BuildMap(const Grid& grid,
                      const std::vector<Points>& pairs,
                      const TerrainOptions& options = {}) {
  ElevationMapBuilder builder(grid, options);
  for (const Points& points : pairs) builder.Add(points);
  return builder.Build();
}

bool SameBytes(const cv::Mat1f& a, const cv::Mat1f& b) {
  return a.size() == b.size() && std::equal(a.datastart, a.dataend, b.datastart);
}

// Inverse-distance weighted mean over all points within the radius, straight from its definition.
double NaiveHeight(const Points& points, const Eigen::Vector2d& center, double radius_m) {
  double weights = 0.0, heights = 0.0;
  for (const DensePoint& point : points) {
    const double squared = (point.point_in_world.head<2>().cast<double>() - center).squaredNorm();
    if (squared > radius_m * radius_m) continue;
    weights += 1.0 / squared;
    heights += point.point_in_world.z() / squared;
  }
  return heights / weights;
}

double Rolling(double east, double north) {
  return 2.0 * std::sin(east / 9.0) + 1.5 * std::cos(north / 7.0);
}

double Flat(double, double) { return 3.0; }

TEST_CASE("terrain: the grid around a box is aligned, whole, and row 0 is in the north") {
  const Grid grid = GridAround({-3.2, 10.1}, {4.0, 20.0}, 2.0);
  CHECK(grid.north_west_in_world == Eigen::Vector2d(-4.0, 20.0));
  CHECK(grid.num_cols == 4);
  CHECK(grid.num_rows == 5);
  CHECK(grid.CellCenter(0, 0) == Eigen::Vector2d(-3.0, 19.0));
  CHECK(grid.CellCenter(4, 3) == Eigen::Vector2d(3.0, 11.0));
  CHECK(GridAround({0.1, 0.1}, {0.3, 0.3}, 0.1).num_cols == 2);
  CHECK(GridAround({5.0, 5.0}, {5.0, 5.0}, 1.0).num_rows == 1);
}

TEST_CASE("terrain: CellAt undoes CellCenter and knows the outside") {
  const Grid grid = GridAround({-3.2, 10.1}, {4.0, 20.0}, 0.5);
  for (int row = 0; row < grid.num_rows; ++row) {
    for (int col = 0; col < grid.num_cols; ++col) {
      CHECK(grid.CellAt(grid.CellCenter(row, col)) == cv::Point(col, row));
    }
  }
  CHECK_FALSE(grid.CellAt({-4.1, 15.0}));
  CHECK_FALSE(grid.CellAt({0.0, 20.1}));
  CHECK_FALSE(grid.CellAt({0.0, 1e300}));
  CHECK_FALSE(grid.CellAt({std::nan(""), 15.0}));
}

TEST_CASE("terrain: boxes and grids that make no sense are refused") {
  CHECK_THROWS_AS(GridAround({0, 0}, {1, 1}, 0.0), std::invalid_argument);
  CHECK_THROWS_AS(GridAround({0, 0}, {1, 1}, std::nan("")), std::invalid_argument);
  CHECK_THROWS_AS(GridAround({0, 0}, {std::nan(""), 1}, 1.0), std::invalid_argument);
  CHECK_THROWS_AS(GridAround({2, 0}, {1, 1}, 1.0), std::invalid_argument);
  CHECK_THROWS_AS(GridAround({0, 0}, {1e30, 1}, 1.0), std::invalid_argument);
  TerrainOptions options;
  options.max_num_cells = 99;
  CHECK_THROWS_AS(ElevationMapBuilder(Square(10), options), std::invalid_argument);
}

TEST_CASE("terrain: interpolation agrees with the definition within a micrometre") {
  constexpr double kMaxErrorM = 1e-6;
  const Grid grid = Square(30);
  const Points points = Sample(Rolling, grid, 30000, 0.1, 1);
  for (const double radius_m : {0.7, 1.0, 2.5}) {
    TerrainOptions options;
    options.interpolation_radius_m = radius_m;
    options.outlier_sigma = 1e6;  // no outliers: the plain mean of the paper
    const ElevationMap map = BuildMap(grid, {points, points}, options);
    double max_error = 0.0;
    for (int row = 0; row < grid.num_rows; ++row) {
      for (int col = 0; col < grid.num_cols; ++col) {
        const double truth = NaiveHeight(points, grid.CellCenter(row, col), radius_m);
        max_error = std::max(max_error, std::abs(map.elevation(row, col) - truth));
      }
    }
    CHECK(max_error <= kMaxErrorM);
  }
}

TEST_CASE("terrain: a point exactly on a cell's centre gives its height, not a division by zero") {
  const Grid grid = Square(3);
  const Points points{PointAt(1.5, 1.5, 2.0), PointAt(1.4, 1.5, 2.1), PointAt(1.7, 1.4, 1.9)};
  const ElevationMap map = BuildMap(grid, {points, points});
  CHECK(map.elevation(1, 1) == doctest::Approx(2.0).epsilon(1e-6));
}

TEST_CASE("terrain: without points everything is unknown, and so is a cell with too few") {
  const Grid grid = Square(5);
  for (const ElevationMap& map :
       {BuildMap(grid, {}),
        BuildMap(grid, {{}}),
        BuildMap(grid, {{PointAt(2.5, 2.4, 1.0), PointAt(2.4, 2.5, 1.0)}})}) {
    CHECK(cv::countNonZero(map.elevation == map.elevation) == 0);
    CHECK(cv::countNonZero(map.upper == map.upper) == 0);
    CHECK(cv::countNonZero(map.standard_deviation == map.standard_deviation) == 0);
    CHECK_FALSE(map.IsSeen(2, 2));
  }
  CHECK(BuildMap(Grid{}, {{PointAt(0, 0, 0)}}).elevation.empty());
}

TEST_CASE("terrain: cells farther from any point than the radius stay unknown") {
  const Grid grid = Square(20);
  Points points = Sample(Flat, grid, 8000, 0.05, 2);
  std::erase_if(points, [](const DensePoint& p) { return p.point_in_world.x() > 10.0f; });
  const ElevationMap map = BuildMap(grid, {points, points});
  for (int row = 0; row < 20; ++row) {
    CHECK(map.IsSeen(row, 9));
    CHECK_FALSE(map.IsSeen(row, 11));
  }
}

TEST_CASE("terrain: points that are wild, not finite or outside neither move the ground nor cost") {
  constexpr double kMaxShiftM = 0.05;
  const Grid grid = Square(40);
  const Points clean = Sample(Flat, grid, 40 * 40 * 25, 0.03, 3);
  Points dirty = clean;
  std::mt19937 random(4);
  std::uniform_real_distribution<float> place(-1e6f, 1e6f), wild(-500.0f, 500.0f),
      step(1.0f, 20.0f);
  for (size_t i = 0; i < dirty.size(); i += 100) {
    dirty[i].point_in_world.z() += (i % 200 == 0) ? wild(random) : step(random);
    dirty.push_back({{place(random), place(random), place(random)}, 0.1f});
  }
  dirty.push_back({{kNaN, 1.0f, 1.0f}, 0.1f});
  dirty.push_back({{1.0f, 1.0f, kNaN}, 0.1f});
  dirty.push_back({{1.0f, 1.0f, std::numeric_limits<float>::infinity()}, kNaN});
  const ElevationMap truth = BuildMap(grid, {clean, clean});
  const ElevationMap map = BuildMap(grid, {dirty, clean});
  CHECK(map.grid == grid);
  CHECK(cv::norm(map.elevation, truth.elevation, cv::NORM_INF) < kMaxShiftM);
  // Nor do they raise the upper height, save where two or three of them meet in one cell.
  constexpr double kMaxRaisedShare = 0.005;
  CHECK(cv::countNonZero(map.upper > truth.upper + 0.2) <= kMaxRaisedShare * 40 * 40);
}

TEST_CASE("terrain: a pole of three cells keeps its height in upper and not in elevation") {
  constexpr double kPoleHeightM = 8.0;
  const Grid grid = Square(20);
  // A fifth of the points in the three cells lie on the pole.
  std::vector<Points> pairs{Sample(Flat, grid, 20000, 0.1, 5), Sample(Flat, grid, 20000, 0.1, 6)};
  for (Points& points : pairs) {
    int count = 0;
    for (DensePoint& point : points) {
      const auto cell = grid.CellAt(point.point_in_world.head<2>().cast<double>());
      const bool is_pole = cell && cell->y == 10 && cell->x >= 8 && cell->x <= 10;
      if (is_pole && ++count % 5 == 0) point.point_in_world.z() += kPoleHeightM;
    }
  }
  const ElevationMap map = BuildMap(grid, pairs);
  for (int col = 8; col <= 10; ++col) {
    CHECK(map.upper(10, col) > 3.0 + kPoleHeightM - 0.3);
    CHECK(map.elevation(10, col) == doctest::Approx(3.0).epsilon(0.05));
  }
  CHECK(map.upper(10, 5) < 3.6);
}

TEST_CASE("terrain: one wild point lifts no upper height, however few points there are") {
  const Grid grid = Square(5);
  for (const int num_others : {3, 4, 10, 30}) {
    Points points;
    for (int i = 0; i < num_others; ++i) {
      points.push_back(PointAt(2.1 + 0.8 * i / num_others, 2.3 + 0.01 * i, 1.0 + 0.01 * (i % 3)));
    }
    points.push_back(PointAt(2.5, 2.6, 40.0));
    const Points others(points.begin(), points.end() - 1);
    const ElevationMap map = BuildMap(grid, {points, others});
    CHECK(map.elevation(2, 2) == doctest::Approx(1.0).epsilon(0.03));
    CHECK(map.upper(2, 2) < 1.1);
  }
}

TEST_CASE(
    "terrain: two high points of one pair are chance, of two pairs or three of one are a pole") {
  const Grid grid = Square(5);
  const auto pair_with = [](int num_high) {
    Points points;
    for (int i = 0; i < 9; ++i) {
      const double height = i < num_high ? 7.0 + 0.1 * i : 1.0 + 0.01 * i;
      const int row = i / 3, column = i % 3;
      points.push_back(PointAt(2.15 + 0.3 * column, 2.15 + 0.3 * row, height));
    }
    return points;
  };
  CHECK(BuildMap(grid, {pair_with(2), pair_with(0)}).upper(2, 2) < 1.2);
  CHECK(BuildMap(grid, {pair_with(2), pair_with(0), pair_with(0)}).upper(2, 2) < 1.2);
  CHECK(BuildMap(grid, {pair_with(2), pair_with(2), pair_with(0)}).upper(2, 2) >= 7.0);
  CHECK(BuildMap(grid, {pair_with(3), pair_with(0), pair_with(0)}).upper(2, 2) >= 7.0);
  CHECK(BuildMap(grid, {pair_with(3), pair_with(3)}).elevation(2, 2) < 1.2);
}

TEST_CASE("terrain: a pair that is off is outvoted, but what it saw above counts for clearance") {
  const Grid grid = Square(10);
  std::vector<Points> pairs;
  pairs.reserve(5);
  for (int i = 0; i < 4; ++i) pairs.push_back(Sample(Flat, grid, 3000, 0.1, 10 + i));
  pairs.push_back(Sample([](double, double) { return 9.0; }, grid, 3000, 0.1, 20));
  const ElevationMap map = BuildMap(grid, pairs);
  CHECK(map.elevation(5, 5) == doctest::Approx(3.0).epsilon(0.03));
  CHECK(map.standard_deviation(5, 5) < 0.3);
  CHECK(map.upper(5, 5) > 8.8);
}

TEST_CASE("terrain: a height needs a majority of pairs; what nothing checks is less certain") {
  const Grid grid = Square(10);
  const Points low = Sample(Flat, grid, 3000, 0.1, 1), low_too = Sample(Flat, grid, 3000, 0.1, 2);
  const auto higher = [&](int seed) {
    return Sample([](double, double) { return 8.0; }, grid, 3000, 0.1, seed);
  };
  CHECK_FALSE(BuildMap(grid, {low, higher(3)}).IsSeen(5, 5));
  CHECK_FALSE(BuildMap(grid, {low, low_too, higher(3), higher(4)}).IsSeen(5, 5));
  const ElevationMap outvoted = BuildMap(grid, {low, low_too, higher(3)});
  CHECK(outvoted.elevation(5, 5) == doctest::Approx(3.0).epsilon(0.03));
  CHECK(outvoted.upper(5, 5) > 7.5);
  // One pair alone knows least, and two that agree know less than three.
  CHECK(BuildMap(grid, {low}).standard_deviation(5, 5) > outvoted.standard_deviation(5, 5));
  const ElevationMap three = BuildMap(grid, {low, low_too, Sample(Flat, grid, 3000, 0.1, 5)});
  CHECK(outvoted.standard_deviation(5, 5) > 1.5F * three.standard_deviation(5, 5));
}

TEST_CASE("terrain: deviations of one cell's pairs are told, however sure each pair is of itself") {
  const Grid grid = Square(10);
  std::vector<Points> pairs;
  for (const double height : {2.85, 3.0, 3.15}) {
    pairs.push_back(Sample([height](double, double) { return height; }, grid, 3000, 0.01, 1));
  }
  const ElevationMap map = BuildMap(grid, pairs);
  // 0.15 m of one pair, and of three pairs two are independent.
  CHECK(map.standard_deviation(5, 5) == doctest::Approx(0.15 / std::sqrt(2.0)).epsilon(0.05));
}

TEST_CASE("terrain: beside a step a cell may be as low as its neighbour, and says so") {
  constexpr int kHigh = 5;  // the first column on the step
  constexpr float kGround = 3.0F;
  const Grid grid = Square(10);
  const Surface wall = [](double east, double) { return east < kHigh ? kGround : kGround + 9.0; };
  std::vector<Points> pairs;
  pairs.reserve(4);
  for (int i = 0; i < 4; ++i) pairs.push_back(Sample(wall, grid, 3000, 0.05, 10 + i));
  const ElevationMap map = BuildMap(grid, pairs);
  // The foot of the step takes a part of its height.
  REQUIRE(map.elevation(5, kHigh - 1) > kGround + 0.2F);
  CHECK(map.elevation(5, kHigh - 1) - 3.0F * map.standard_deviation(5, kHigh - 1) < kGround);
  CHECK(map.elevation(5, kHigh) - 3.0F * map.standard_deviation(5, kHigh) <
        map.elevation(5, kHigh - 1));
  CHECK(map.standard_deviation(5, 1) < 0.15F);
  CHECK(map.standard_deviation(5, 8) < 0.15F);
}

TEST_CASE("terrain: one wild landmark does not unsettle dense ground") {
  const Grid grid = Square(10);
  const Points dense = Sample(Flat, grid, 3000, 0.1, 1);
  const ElevationMap map = BuildMap(grid, {dense, dense, {PointAt(5.4, 4.6, 11.0)}});
  const ElevationMap truth = BuildMap(grid, {dense, dense});
  CHECK(SameBytes(map.elevation, truth.elevation));
  CHECK(SameBytes(map.upper, truth.upper));
}

TEST_CASE("terrain: the order of the pairs changes no bit") {
  const Grid grid = Square(25);
  std::vector<Points> pairs;
  pairs.reserve(6);
  for (int i = 0; i < 6; ++i) pairs.push_back(Sample(Rolling, grid, 4000 + 500 * i, 0.2, 30 + i));
  const ElevationMap map = BuildMap(grid, pairs);
  std::mt19937 random(1);
  for (int i = 0; i < 5; ++i) {
    std::shuffle(pairs.begin(), pairs.end(), random);
    const ElevationMap other = BuildMap(grid, pairs);
    CHECK(SameBytes(map.elevation, other.elevation));
    CHECK(SameBytes(map.upper, other.upper));
    CHECK(SameBytes(map.standard_deviation, other.standard_deviation));
    CHECK(SameBytes(map.num_points, other.num_points));
  }
}

TEST_CASE("terrain: upper is nowhere below elevation, and more pairs make it more certain") {
  const Grid grid = Square(20);
  std::vector<Points> pairs;
  pairs.reserve(8);
  for (int i = 0; i < 8; ++i) pairs.push_back(Sample(Rolling, grid, 2000, 0.3, 40 + i));
  const ElevationMap map = BuildMap(grid, pairs);
  const ElevationMap few = BuildMap(grid, {pairs[0], pairs[1]});
  CHECK(cv::countNonZero(map.upper < map.elevation) == 0);
  CHECK(cv::countNonZero(few.upper < few.elevation) == 0);
  const auto mean_of = [](const ElevationMap& each) {
    return cv::mean(each.standard_deviation, each.elevation == each.elevation)[0];
  };
  CHECK(mean_of(map) < 0.6 * mean_of(few));
}

TEST_CASE("terrain: Check names field, value and constraint") {
  using O = TerrainOptions;
  CHECK_NOTHROW(O().Check());
  CHECK(RefusalOf(&O::cell_size_m, 0.0) == "terrain.cell_size_m = 0: must be in [0.05, 100]");
  CHECK(IsRefused(&O::interpolation_radius_m, -1.0, "interpolation_radius_m"));
  CHECK(IsRefused(&O::min_num_points, 0, "min_num_points"));
  CHECK(IsRefused(&O::outlier_sigma, std::nan(""), "outlier_sigma"));
  CHECK(IsRefused(&O::upper_percentile, 101.0, "upper_percentile"));
  CHECK(IsRefused(&O::max_relief_m, 0.0, "max_relief_m"));
  CHECK(IsRefused(&O::max_num_cells, 0, "max_num_cells"));
}

}  // namespace
}  // namespace freelsd
