#include <algorithm>
#include <cmath>

#include <doctest/doctest.h>

#include "api/export/map/map_layer.h"
#include "tests/api/export/map/scenes.h"

namespace freelsd {
namespace {

// Hazard of the cell that shows the place; unseen where no window is.
uint8_t ShownHazard(const CellFinder& finder, const Eigen::Vector2d& place) {
  const WindowCell cell = finder.At(place);
  if (!cell.window) return kUnseen;
  return cell.window->site_map.layers.hazard(cell.row, cell.col);
}

TEST_CASE("map: a coarse cell is free only if all cells in it are, in any choice of windows") {
  for (uint32_t seed = 0; seed < 8; ++seed) {
    // Parts that overlap, with edges at odd places, each with gaps that the others fill.
    const std::vector<MapWindow> windows{
        RandomWindow({{-37.0, 21.0}, 1.0, 61, 53}, {seed, 0.02, 0.10}),
        RandomWindow({{-10.0, 33.0}, 1.0, 40, 50}, {seed + 100, 0.05, 0.20}),
        RandomWindow({{-20.0, 5.0}, 1.0, 33, 47}, {seed + 200, 0.00, 0.05})};
    const auto levels = LevelsOf(windows, 4);
    const CellFinder fine(levels[0]);
    for (int level = 1; level < 4; ++level) {
      const CellFinder coarse(levels[level]);
      int num_free = 0;
      for (int y = -60; y < 40; ++y) {
        for (int x = -60; x < 60; ++x) {
          const Eigen::Vector2d place(x + 0.5, y + 0.5);
          if (ShownHazard(coarse, place) != kFree) continue;
          ++num_free;
          REQUIRE(ShownHazard(fine, place) == kFree);
        }
      }
      if (level == 1) CHECK(num_free > 500);
    }
  }
}

TEST_CASE("map: coarse cells lie at multiples of their size and hold the least favourable values") {
  MapWindow fine = RandomWindow({{-3.0, 5.0}, 1.0, 6, 7}, {1, 0.0, 0.0});
  const MapWindow coarse = Coarser(fine);
  const Grid& grid = coarse.site_map.map.grid;
  CHECK(grid.north_west_in_world == Eigen::Vector2d(-4.0, 6.0));
  CHECK(grid.cell_size_m == 2.0);
  CHECK(grid.num_rows == 4);
  CHECK(grid.num_cols == 4);
  CHECK(coarse.site_map.layers.grid == grid);
  // Cells outside count as unseen.
  const HazardLayers& layers = coarse.site_map.layers;
  CHECK(layers.hazard(0, 1) == kUnseen);
  CHECK(layers.hazard(1, 0) == kUnseen);
  CHECK(std::isnan(layers.slope(0, 1)));
  CHECK(coarse.coverage(0, 1) == 0);
  CHECK(layers.distance(0, 1) == 0.0f);
  // Rows 1 and 2, columns 1 and 2 of the fine window.
  const auto four = [](const cv::Mat1f& m) { return cv::Mat1f(m(cv::Rect(1, 1, 2, 2)).clone()); };
  const auto max_of = [&](const cv::Mat1f& m) {
    const cv::Mat1f values = four(m);
    return *std::max_element(values.begin(), values.end());
  };
  const auto min_of = [&](const cv::Mat1f& m) {
    const cv::Mat1f values = four(m);
    return *std::min_element(values.begin(), values.end());
  };
  const auto& [map, fine_layers] = fine.site_map;
  CHECK(layers.hazard(1, 1) == kFree);
  CHECK(coarse.site_map.map.elevation(1, 1) == doctest::Approx(cv::mean(four(map.elevation))[0]));
  CHECK(coarse.site_map.map.upper(1, 1) == max_of(map.upper));
  CHECK(coarse.site_map.map.standard_deviation(1, 1) == max_of(map.standard_deviation));
  CHECK(layers.slope(1, 1) == max_of(fine_layers.slope));
  CHECK(layers.roughness(1, 1) == max_of(fine_layers.roughness));
  CHECK(layers.grass(1, 1) == min_of(fine_layers.grass));
  CHECK(layers.distance(1, 1) == min_of(fine_layers.distance));
  CHECK(coarse.coverage(1, 1) == 3);
}

TEST_CASE("map: one unknown value makes the coarse value unknown, except the heights") {
  MapWindow fine = RandomWindow({{0.0, 4.0}, 1.0, 4, 4}, {1, 0.0, 0.0});
  auto& [map, layers] = fine.site_map;
  for (cv::Mat1f* raster : {&map.elevation,
                            &map.upper,
                            &map.standard_deviation,
                            &layers.slope,
                            &layers.roughness,
                            &layers.grass}) {
    (*raster)(0, 0) = std::nanf("");
  }
  layers.hazard(0, 0) = kUnseen;
  layers.hazard(2, 2) = kUnseen;
  layers.hazard(3, 3) = kHazard;
  const MapWindow coarse = Coarser(fine);
  CHECK(std::isfinite(coarse.site_map.map.elevation(0, 0)));
  CHECK(coarse.site_map.map.upper(0, 0) ==
        std::max({map.upper(0, 1), map.upper(1, 0), map.upper(1, 1)}));
  CHECK(std::isnan(coarse.site_map.map.standard_deviation(0, 0)));
  CHECK(std::isnan(coarse.site_map.layers.slope(0, 0)));
  CHECK(std::isnan(coarse.site_map.layers.roughness(0, 0)));
  CHECK(std::isnan(coarse.site_map.layers.grass(0, 0)));
  CHECK(coarse.site_map.layers.hazard(0, 0) == kUnseen);
  CHECK(coarse.site_map.layers.hazard(1, 1) == kHazard);
  CHECK(coarse.site_map.layers.hazard(0, 1) == kFree);
}

TEST_CASE("map: a coarse photo has the mean of the seen pixels") {
  PhotoWindow fine{{{0.0, 0.4}, 0.1, 4, 4}, cv::Mat4b(4, 4, cv::Vec4b(0, 0, 0, 0))};
  fine.pixels(0, 0) = {10, 20, 30, 255};
  fine.pixels(1, 1) = {30, 40, 50, 255};
  const PhotoWindow coarse = Coarser(fine);
  CHECK(coarse.grid.num_rows == 2);
  CHECK(coarse.pixels(0, 0) == cv::Vec4b(20, 30, 40, 255));
  CHECK(coarse.pixels(1, 1)[3] == 0);
}

TEST_CASE("map: a grid off its lattice is refused") {
  MapWindow window = RandomWindow({{0.25, 4.0}, 1.0, 4, 4}, {});
  CHECK_THROWS_AS(Coarser(window), std::invalid_argument);
  CHECK_THROWS_AS(Coarser(PhotoWindow{{{0.0, 0.47}, 0.1, 4, 4}, cv::Mat4b(4, 4)}),
                  std::invalid_argument);
}

}  // namespace
}  // namespace freelsd
