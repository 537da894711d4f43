#include "engine/terrain/weighted_sums.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <doctest/doctest.h>

#include "engine/terrain/cell_points.h"
#include "engine/terrain/pair_summary.h"

namespace freelsd {
namespace {

constexpr double kSameHeightM = 1e-9;

class Random {
 public:
  double Uniform(double low, double high) { return low + (high - low) * (next_() / 4294967296.0); }

 private:
  std::mt19937 next_{5};
};

Points Scattered(Random& random, size_t count, double half_m) {
  Points points(count);
  for (DensePoint& point : points) {
    const double x = random.Uniform(-half_m, half_m), y = random.Uniform(-half_m, half_m);
    const double z = 300.0 + 3.0 * std::sin(x / 4.0) + random.Uniform(-0.3, 0.3);
    point = {Eigen::Vector3d(x, y, z).cast<float>(), static_cast<float>(random.Uniform(0.1, 0.3))};
  }
  // On a cell's centre, and on its corner.
  points[0].point_in_world = {0.5f, 0.5f, 301.0f};
  points[1].point_in_world = {2.0f, -1.0f, 299.0f};
  return points;
}

// The definition, point by point and cell by cell.
CellSums NaiveSums(
    const Points& points, const Grid& grid, int row, int col, double radius, double base_height) {
  CellSums sums;
  const Eigen::Vector2d center = grid.CellCenter(row, col);
  for (const DensePoint& point : points) {
    const Eigen::Vector3d place = point.point_in_world.cast<double>();
    const double distance = (place.head<2>() - center).norm();
    if (distance > radius) continue;
    const double weight = 1.0 / std::pow(std::max(distance, kExactHitM), 2);
    const double height = place.z() - base_height;
    sums.weight += weight;
    sums.height += weight * height;
    sums.squared_height += weight * height * height;
    sums.num_points += 1.0;
    sums.variance += std::pow(static_cast<double>(point.height_sd_m), 2);
  }
  return sums;
}

TEST_CASE("weighted sums: the plain definition in double, to 1e-9 m, near and wide") {
  Random random;
  const Points points = Scattered(random, 3000, 9.0);
  for (const double cell_size : {0.5, 1.0}) {
    const Grid grid = GridAround({-8.0, -7.0}, {8.0, 7.0}, cell_size);
    for (const double radius : {0.3 * cell_size, cell_size, 2.3 * cell_size}) {
      const cv::Rect part(2, 1, grid.num_cols - 5, grid.num_rows - 3);
      WeightedSums sums(grid, part, radius, 299.0, SumKind::kAll);
      WeightedSums means(grid, part, radius, 299.0, SumKind::kMeanOnly);
      sums.Add(points.data(), points.size());
      means.Add(points.data(), points.size());
      for (int row = 0; row < part.height; ++row) {
        for (int col = 0; col < part.width; ++col) {
          const CellSums naive = NaiveSums(points, grid, row + part.y, col + part.x, radius, 299.0);
          const CellSums sum = sums.At(row, col), mean = means.At(row, col);
          REQUIRE(sum.num_points == naive.num_points);
          if (naive.num_points == 0.0) continue;
          CHECK(std::abs(sum.height / sum.weight - naive.height / naive.weight) < kSameHeightM);
          CHECK(std::abs(mean.height / mean.weight - naive.height / naive.weight) < kSameHeightM);
          CHECK(sum.squared_height == doctest::Approx(naive.squared_height).epsilon(1e-9));
          CHECK(sum.variance == doctest::Approx(naive.variance).epsilon(1e-9));
        }
      }
    }
  }
}

TEST_CASE("weighted sums: points that are not finite or far off add nothing") {
  const Grid grid = GridAround({0.0, 0.0}, {4.0, 4.0}, 1.0);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  const Points points{{{nan, 1.0f, 1.0f}, 0.1f},
                      {{1.0f, infinity, 1.0f}, 0.1f},
                      {{1.5f, 1.5f, nan}, 0.1f},
                      {{1e30f, -1e30f, 1.0f}, 0.1f},
                      {{-1.2f, 2.0f, 1.0f}, 0.1f},
                      {{5.2f, 2.0f, 1.0f}, 0.1f}};
  for (const double radius : {1.0, 2.0}) {
    WeightedSums sums(grid, {0, 0, 4, 4}, radius, 0.0, SumKind::kAll);
    sums.Add(points.data(), radius == 1.0 ? points.size() : 4);
    for (int row = 0; row < 4; ++row) {
      for (int col = 0; col < 4; ++col) CHECK(sums.At(row, col).num_points == 0.0);
    }
  }
}

TEST_CASE("weighted sums: what a pair says of a cell is its inliers' mean, to 1e-9 m") {
  Random random;
  const Points points = Scattered(random, 4000, 9.0);
  const Grid grid = GridAround({-8.0, -7.0}, {8.0, 7.0}, 1.0);
  TerrainOptions options;
  options.outlier_sigma = 1e5;
  for (const CellSummary& summary : PairSummarizer(grid, options).Summarize(points)) {
    const auto cell = static_cast<int>(summary.cell);
    // Points outside the grid take no part.
    Points inside;
    std::copy_if(points.begin(), points.end(), std::back_inserter(inside), [&](const auto& point) {
      return grid.CellAt(point.point_in_world.template head<2>().template cast<double>());
    });
    const CellSums naive =
        NaiveSums(inside, grid, cell / grid.num_cols, cell % grid.num_cols, 1.0, 300.0);
    REQUIRE(summary.num_points == naive.num_points);
    CHECK(std::abs(summary.mean - 300.0 - naive.height / naive.weight) < kSameHeightM);
  }
}

TEST_CASE("weighted sums: heights sorted by rank are those of std::sort, ties included") {
  Random random;
  for (size_t count = 0; count < 80; ++count) {
    std::vector<float> heights(count);
    for (float& height : heights) {
      height = static_cast<float>(std::floor(random.Uniform(-20.0, 20.0)) / 4.0);
    }
    std::vector<float> sorted = heights;
    std::sort(sorted.begin(), sorted.end());
    SortHeights(heights);
    CHECK(heights == sorted);
  }
}

TEST_CASE("terrain: the paper's mean is the weighted mean of all pairs' points") {
  Random random;
  const Points points = Scattered(random, 4000, 9.0);
  const Grid grid = GridAround({-8.0, -7.0}, {8.0, 7.0}, 1.0);
  TerrainOptions options;
  options.height_fusion = HeightFusion::kPaperMean;
  ElevationMapBuilder builder(grid, options);
  builder.Add({});
  builder.Add(Points(points.begin(), points.begin() + 1500));
  builder.Add(Points(points.begin() + 1500, points.end()));
  const ElevationMap map = builder.Build();
  // A float at 300 m.
  constexpr double kRoundingM = 2e-5;
  for (int row = 0; row < grid.num_rows; ++row) {
    for (int col = 0; col < grid.num_cols; ++col) {
      const CellSums naive = NaiveSums(points, grid, row, col, 1.0, 300.0);
      const double mean = 300.0 + naive.height / naive.weight;
      CHECK(std::abs(map.elevation(row, col) - mean) < kRoundingM);
      CHECK(map.upper(row, col) == map.elevation(row, col));
    }
  }
}

}  // namespace
}  // namespace freelsd
