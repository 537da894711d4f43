#include <doctest/doctest.h>

#include "engine/terrain/terrain.h"

namespace freelsd {
namespace {

// Two metres a cell; from -10 to 10 east and from -20 to 20 north.
Grid SmallGrid() {
  Grid grid;
  grid.north_west_in_world = {-10.0, 20.0};
  grid.cell_size_m = 2.0;
  grid.num_rows = 20;
  grid.num_cols = 10;
  return grid;
}

const Polygon kTriangle{{-4.5, -7.0}, {5.0, 0.5}, {-3.0, 9.0}};

TEST_CASE("grid: the cells in a polygon are those whose centre it contains, row by row") {
  const Grid grid = SmallGrid();
  std::vector<cv::Point> expected;
  for (int row = 0; row < grid.num_rows; ++row) {
    for (int col = 0; col < grid.num_cols; ++col) {
      if (Contains(kTriangle, grid.CellCenter(row, col))) expected.emplace_back(col, row);
    }
  }
  CHECK(expected.size() > 10);
  CHECK(grid.CellsIn(kTriangle) == expected);
}

TEST_CASE("grid: of a polygon that reaches beyond the grid only its cells are given") {
  const Grid grid = SmallGrid();
  const Polygon large{{-99.0, -99.0}, {99.0, -99.0}, {99.0, 99.0}, {-99.0, 99.0}};
  CHECK(grid.CellsIn(large).size() == 200);
  CHECK(grid.CellsAround(large, 0.0) == cv::Rect(0, 0, 10, 20));
  CHECK(grid.CellsAround(kTriangle, 1e300) == cv::Rect(0, 0, 10, 20));
  Polygon beside = large;
  for (Eigen::Vector2d& vertex : beside) vertex.x() += 500.0;
  CHECK(grid.CellsIn(beside).empty());
  CHECK(grid.CellsAround(beside, 0.0).empty());
  CHECK(grid.CellsAround({}, 5.0).empty());
  CHECK(grid.CellsIn({}).empty());
}

TEST_CASE("grid: the cells around a polygon hold its bounding box and the reach") {
  const Grid grid = SmallGrid();
  CHECK(grid.CellsAround(kTriangle, 0.0) == cv::Rect(2, 5, 6, 9));
  CHECK(grid.CellsAround(kTriangle, 2.5) == cv::Rect(1, 4, 8, 11));
}

TEST_CASE("grid: an edge on a line of the grid is not in the cell beyond") {
  const Polygon square{{-2.0, -2.0}, {2.0, -2.0}, {2.0, 2.0}, {-2.0, 2.0}};
  CHECK(SmallGrid().CellsAround(square, 0.0) == cv::Rect(4, 9, 2, 2));
}

}  // namespace
}  // namespace freelsd
