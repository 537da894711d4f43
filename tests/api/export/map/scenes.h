// Parts of a flight's map for tests of what is made of it.
#pragma once

#include <random>
#include <vector>

#include "api/export/map/map.h"
#include "tests/api/export/layers/hill_map.h"

namespace freelsd {

inline LocalFrame FrameAt(double latitude_deg, double longitude_deg) {
  return LocalFrame({latitude_deg, longitude_deg, 450.0});
}

// HillMap with the number of photographs: the column's.
inline MapWindow HillWindow() {
  MapWindow window{HillMap(), {}};
  window.coverage = cv::Mat1b(kHillRows, kHillCols);
  for (int row = 0; row < kHillRows; ++row) {
    for (int col = 0; col < kHillCols; ++col) {
      window.coverage(row, col) = static_cast<uint8_t>(col);
    }
  }
  return window;
}

struct RandomCells {
  uint32_t seed = 0;
  // Of a cell.
  double hazard_probability = 0.01;
  double unseen_probability = 0.01;
};

// Cells without any relation to their neighbours.
inline MapWindow RandomWindow(const Grid& grid, const RandomCells& cells) {
  std::mt19937 random(cells.seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  MapWindow window;
  auto& [map, layers] = window.site_map;
  map.grid = layers.grid = grid;
  const auto raster = [&](double low, double high) {
    cv::Mat1f values(grid.num_rows, grid.num_cols);
    for (float& value : values) value = static_cast<float>(low + (high - low) * uniform(random));
    return values;
  };
  map.elevation = raster(0.0, 30.0);
  map.upper = map.elevation + 0.5;
  map.standard_deviation = raster(0.05, 0.5);
  map.num_points = raster(3.0, 50.0);
  layers.slope = raster(0.0, 0.3);
  layers.roughness = raster(0.0, 1.0);
  layers.grass = raster(0.0, 1.0);
  layers.distance = raster(1.0, 40.0);
  layers.hazard = cv::Mat1b(grid.num_rows, grid.num_cols, kFree);
  window.coverage = cv::Mat1b(grid.num_rows, grid.num_cols, 3);
  for (int row = 0; row < grid.num_rows; ++row) {
    for (int col = 0; col < grid.num_cols; ++col) {
      const double draw = uniform(random);
      if (draw < cells.hazard_probability) {
        layers.hazard(row, col) = kHazard;
        layers.distance(row, col) = 0.0f;
      } else if (draw < cells.hazard_probability + cells.unseen_probability) {
        layers.hazard(row, col) = kUnseen;
        layers.distance(row, col) = 0.0f;
        layers.slope(row, col) = map.elevation(row, col) = std::nanf("");
      }
    }
  }
  return window;
}

// The windows of each level, the finest first.
inline std::vector<std::vector<MapWindow>> LevelsOf(std::vector<MapWindow> windows,
                                                    int num_levels) {
  std::vector<std::vector<MapWindow>> levels{windows};
  while (static_cast<int>(levels.size()) < num_levels) {
    for (MapWindow& window : windows) window = Coarser(window);
    levels.push_back(windows);
  }
  return levels;
}

inline WorldBox BoxOf(const Grid& grid) {
  const std::vector<Eigen::Vector2d> corners = OuterCorners(grid);
  return {corners[3], corners[1]};
}

constexpr int kNumLevels = 4;
template <typename Window>
auto SourceOf(const std::vector<std::vector<Window>>& levels) {
  return [levels](const WorldBox&, int level) { return levels[level]; };
}

// Two random windows that overlap, with their levels.
inline MapSource TwoWindows() {
  const std::vector<MapWindow> windows{
      RandomWindow({{-310.0, 290.0}, 1.0, 520, 400}, {1, 0.002, 0.002}),
      RandomWindow({{50.0, 310.0}, 1.0, 450, 300}, {2, 0.002, 0.01})};
  return {{{-310.0, -230.0}, {350.0, 310.0}},
          1.0,
          kNumLevels,
          SourceOf(LevelsOf(windows, kNumLevels)),
          {}};
}

}  // namespace freelsd
