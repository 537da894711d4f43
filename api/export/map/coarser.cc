#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "api/export/map/map.h"

namespace freelsd {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
// Share of a cell by which a grid's edge may miss its lattice.
constexpr double kAlignmentTolerance = 1e-4;

// The coarse grid, and the fine row and column at which its first cell begins: 0 or -1.
struct CoarseGrid {
  Grid grid;
  int first_row = 0;
  int first_col = 0;
};

double IndexOnLattice(double place_m, double cell_size_m) {
  const double index = std::round(place_m / cell_size_m);
  if (!(std::abs(place_m / cell_size_m - index) <= kAlignmentTolerance)) {
    throw std::invalid_argument("window.grid: its edge at " + std::to_string(place_m) +
                                " m is not at a multiple of the cell size " +
                                std::to_string(cell_size_m) + " m");
  }
  return index;
}

CoarseGrid CoarserGrid(const Grid& fine) {
  const double west = IndexOnLattice(fine.north_west_in_world.x(), fine.cell_size_m);
  const double north = IndexOnLattice(fine.north_west_in_world.y(), fine.cell_size_m);
  const double coarse_west = std::floor(west / 2.0), coarse_north = std::ceil(north / 2.0);
  CoarseGrid coarse;
  coarse.first_col = static_cast<int>(2.0 * coarse_west - west);
  coarse.first_row = static_cast<int>(north - 2.0 * coarse_north);
  coarse.grid.cell_size_m = 2.0 * fine.cell_size_m;
  coarse.grid.north_west_in_world =
      Eigen::Vector2d(coarse_west, coarse_north) * coarse.grid.cell_size_m;
  coarse.grid.num_cols = (fine.num_cols - coarse.first_col + 1) / 2;
  coarse.grid.num_rows = (fine.num_rows - coarse.first_row + 1) / 2;
  return coarse;
}

// Joins four values to one, everywhere. Cells outside the raster are `outside`.
template <typename T, typename Join>
cv::Mat_<T> JoinFours(const cv::Mat_<T>& fine, const CoarseGrid& coarse, T outside, Join join) {
  if (fine.empty()) return {};
  cv::Mat_<T> joined(coarse.grid.num_rows, coarse.grid.num_cols);
  for (int row = 0; row < joined.rows; ++row) {
    for (int col = 0; col < joined.cols; ++col) {
      std::array<T, 4> four;
      for (int i = 0; i < 4; ++i) {
        const int r = coarse.first_row + 2 * row + i / 2, c = coarse.first_col + 2 * col + i % 2;
        const bool is_inside = r >= 0 && c >= 0 && r < fine.rows && c < fine.cols;
        four[i] = is_inside ? fine(r, c) : outside;
      }
      joined(row, col) = join(four);
    }
  }
  return joined;
}

bool HasUnknown(const std::array<float, 4>& four) {
  return std::any_of(four.begin(), four.end(), [](float value) { return std::isnan(value); });
}

float Least(const std::array<float, 4>& four) {
  return HasUnknown(four) ? kNaN : *std::min_element(four.begin(), four.end());
}

float Largest(const std::array<float, 4>& four) {
  return HasUnknown(four) ? kNaN : *std::max_element(four.begin(), four.end());
}

float LargestKnown(const std::array<float, 4>& four) {
  float largest = kNaN;
  for (const float value : four) {
    if (!(largest >= value) && !std::isnan(value)) largest = value;
  }
  return largest;
}

float MeanOfKnown(const std::array<float, 4>& four) {
  double sum = 0.0;
  int count = 0;
  for (const float value : four) {
    if (std::isnan(value)) continue;
    sum += value;
    ++count;
  }
  return count > 0 ? static_cast<float>(sum / count) : kNaN;
}

// Not unseen before hazard: another window may have seen all four as free, and would then be shown.
uint8_t WorstHazard(const std::array<uint8_t, 4>& four) {
  const auto has = [&](uint8_t hazard) {
    return std::find(four.begin(), four.end(), hazard) != four.end();
  };
  if (has(kHazard)) return kHazard;
  return std::all_of(four.begin(), four.end(), [](uint8_t value) { return value == kFree; })
             ? kFree
             : kUnseen;
}

cv::Vec4b MeanColor(const std::array<cv::Vec4b, 4>& four) {
  cv::Vec3i sum(0, 0, 0);
  int weight = 0, alpha = 0;
  for (const cv::Vec4b& pixel : four) {
    for (int i = 0; i < 3; ++i) sum[i] += pixel[i] * pixel[3];
    weight += pixel[3];
    alpha = std::max<int>(alpha, pixel[3]);
  }
  if (weight == 0) return {0, 0, 0, 0};
  cv::Vec4b mean;
  for (int i = 0; i < 3; ++i) mean[i] = static_cast<uint8_t>((sum[i] + weight / 2) / weight);
  mean[3] = static_cast<uint8_t>(alpha);
  return mean;
}

}  // namespace

MapWindow Coarser(const MapWindow& window) {
  const CoarseGrid coarse = CoarserGrid(window.site_map.map.grid);
  MapWindow result = window;
  auto& [map, layers] = result.site_map;
  map.grid = layers.grid = coarse.grid;
  map.elevation = JoinFours(map.elevation, coarse, kNaN, MeanOfKnown);
  map.upper = JoinFours(map.upper, coarse, kNaN, LargestKnown);
  map.standard_deviation = JoinFours(map.standard_deviation, coarse, kNaN, Largest);
  map.num_points = JoinFours(map.num_points, coarse, kNaN, Least);
  layers.slope = JoinFours(layers.slope, coarse, kNaN, Largest);
  layers.roughness = JoinFours(layers.roughness, coarse, kNaN, Largest);
  layers.grass = JoinFours(layers.grass, coarse, kNaN, Least);
  // Another kind before grass, and grass before nothing.
  layers.kind = JoinFours<uint8_t>(layers.kind, coarse, 0, [](const std::array<uint8_t, 4>& four) {
    return *std::max_element(four.begin(), four.end());
  });
  layers.hazard = JoinFours<uint8_t>(layers.hazard, coarse, kUnseen, WorstHazard);
  layers.distance = JoinFours(layers.distance, coarse, 0.0f, Least);
  result.cues.clear();
  result.risk = JoinFours(result.risk, coarse, kNaN, Largest);
  result.coverage =
      JoinFours<uint8_t>(result.coverage, coarse, 0, [](const std::array<uint8_t, 4>& four) {
        return *std::min_element(four.begin(), four.end());
      });
  return result;
}

PhotoWindow Coarser(const PhotoWindow& window) {
  const CoarseGrid coarse = CoarserGrid(window.grid);
  return {coarse.grid, JoinFours(window.pixels, coarse, cv::Vec4b(0, 0, 0, 0), MeanColor)};
}

}  // namespace freelsd
