#include "tests/evaluation/scores/map_shift.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace freelsd {
namespace {

// Around the mean error of the cameras, and around the shift of the whole map.
constexpr int kWholeReachM = 8;
constexpr int kTileReachM = 3;
// A tile and its surroundings tell its shift.
constexpr double kWindowM = 2.0 * MapOffset::kTileM;
// Above it one thing is as good as another: crowns must not outweigh hedges.
constexpr float kMaxReliefM = 3.0f;
// Below it there is the noise of heights.
constexpr float kMinReliefM = 0.4f;
// Of the whole map, every n-th cell of every n-th row.
constexpr int kStepOfWhole = 2;
// A tile has its own shift if that explains so much more.
constexpr double kMaxCostRatio = 0.9;
constexpr size_t kMinNumCells = 500;

struct ReliefCell {
  Eigen::Vector2d place_on_map;
  // What stands there on the map, metres.
  float height = 0.0f;
};

float Limited(double height) {
  const float relief = static_cast<float>(height);
  return relief < kMinReliefM ? 0.0f : std::min(relief, kMaxReliefM);
}

cv::Mat1f TrueRelief(const World& world, const TruthMap& truth) {
  cv::Mat1f relief(truth.top.size());
  for (int row = 0; row < relief.rows; ++row) {
    for (int col = 0; col < relief.cols; ++col) {
      const Eigen::Vector2d place = truth.CellCenter(row, col);
      relief(row, col) = Limited(truth.top(row, col) - world.GroundHeight(place.x(), place.y()));
    }
  }
  return relief;
}

// Without water, whose heights on a map are accidental.
std::vector<ReliefCell> ReliefOfMap(const World& world,
                                    const TruthMap& truth,
                                    const ElevationMap& map,
                                    const MapOffset& offset) {
  std::vector<ReliefCell> cells;
  for (int row = 0; row < map.grid.num_rows; ++row) {
    for (int col = 0; col < map.grid.num_cols; ++col) {
      if (!std::isfinite(map.upper(row, col))) continue;
      const Eigen::Vector2d place = map.grid.CellCenter(row, col);
      const Eigen::Vector2d truly = place - offset.shift;
      if (truth.cover(truth.CellAt(truly)) == static_cast<uint8_t>(Cover::kWater)) continue;
      const double ground = world.GroundHeight(truly.x(), truly.y()) + offset.height.At(truly);
      cells.push_back({place, Limited(map.upper(row, col) - ground)});
    }
  }
  return cells;
}

// Mean difference of what stands on the map and in the world, if the map is shifted.
double CostOf(const std::vector<ReliefCell>& cells,
              const TruthMap& truth,
              const cv::Mat1f& relief,
              const Eigen::Vector2d& shift) {
  double sum = 0.0;
  for (const ReliefCell& cell : cells) {
    sum += std::abs(cell.height - relief(truth.CellAt(cell.place_on_map - shift)));
  }
  return sum / static_cast<double>(std::max<size_t>(1, cells.size()));
}

struct Best {
  Eigen::Vector2d shift;
  double cost = std::numeric_limits<double>::infinity();
};

// In steps of a metre, the cell of both maps. The nearest of equal shifts.
Best SearchAround(const std::vector<ReliefCell>& cells,
                  const TruthMap& truth,
                  const cv::Mat1f& relief,
                  const Eigen::Vector2d& middle,
                  int reach) {
  Best best{middle, CostOf(cells, truth, relief, middle)};
  for (int east = -reach; east <= reach; ++east) {
    for (int north = -reach; north <= reach; ++north) {
      const Eigen::Vector2d shift = middle + Eigen::Vector2d(east, north);
      const double cost = CostOf(cells, truth, relief, shift);
      if (cost < best.cost) best = {shift, cost};
    }
  }
  return best;
}

std::pair<int, int> TileAt(const Eigen::Vector2d& place) {
  return {static_cast<int>(std::floor(place.x() / MapOffset::kTileM)),
          static_cast<int>(std::floor(place.y() / MapOffset::kTileM))};
}

std::vector<ReliefCell> Around(const std::vector<ReliefCell>& cells,
                               const std::pair<int, int>& tile) {
  const Eigen::Vector2d middle =
      MapOffset::kTileM * Eigen::Vector2d(tile.first + 0.5, tile.second + 0.5);
  std::vector<ReliefCell> near;
  std::copy_if(cells.begin(), cells.end(), std::back_inserter(near), [&](const ReliefCell& cell) {
    return (cell.place_on_map - middle).cwiseAbs().maxCoeff() <= 0.5 * kWindowM;
  });
  return near;
}

std::vector<ReliefCell> EveryNth(const ElevationMap& map, const std::vector<ReliefCell>& cells) {
  std::vector<ReliefCell> sample;
  std::copy_if(cells.begin(), cells.end(), std::back_inserter(sample), [&](const ReliefCell& cell) {
    const cv::Point at = map.grid.CellAt(cell.place_on_map).value_or(cv::Point());
    return at.x % kStepOfWhole == 0 && at.y % kStepOfWhole == 0;
  });
  return sample;
}

}  // namespace

Eigen::Vector2d MapOffset::ShiftAt(const Eigen::Vector2d& place) const {
  const auto own = shift_of_tile.find(TileAt(place));
  return own == shift_of_tile.end() ? shift : own->second;
}

MapOffset OffsetOfMap(const World& world,
                      const TruthMap& truth,
                      const ElevationMap& map,
                      const ErrorPlane& height,
                      const Eigen::Vector2d& cameras) {
  MapOffset offset{cameras, height};
  if (map.elevation.empty()) return offset;
  const cv::Mat1f relief = TrueRelief(world, truth);
  const std::vector<ReliefCell> cells = ReliefOfMap(world, truth, map, offset);
  offset.shift = SearchAround(EveryNth(map, cells), truth, relief, cameras, kWholeReachM).shift;
  const int num_tiles = static_cast<int>(std::ceil(0.5 * world.size_m / MapOffset::kTileM));
  for (int east = -num_tiles; east < num_tiles; ++east) {
    for (int north = -num_tiles; north < num_tiles; ++north) {
      const std::vector<ReliefCell> near = Around(cells, {east, north});
      if (near.size() < kMinNumCells) continue;
      const double cost = CostOf(near, truth, relief, offset.shift);
      const Best own = SearchAround(near, truth, relief, offset.shift, kTileReachM);
      if (own.cost < kMaxCostRatio * cost) offset.shift_of_tile[{east, north}] = own.shift;
    }
  }
  return offset;
}

}  // namespace freelsd
