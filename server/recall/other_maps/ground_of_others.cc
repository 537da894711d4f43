#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "server/recall/other_maps/map_places.h"
#include "server/recall/other_maps/other_maps.h"

namespace freelsd {
namespace {

// Cells between two that are compared to level the maps, and the least number of these.
constexpr int kStrideOfCommonCells = 4;
constexpr size_t kMinNumCommonCells = 100;
// Of the common cells, this share may have been higher for the other flight, or lower for this one:
// crops and trees grow and are cut. The ground that both saw unchanged is among the rest, or the
// other map's heights are taken as too high, which is safe.
constexpr double kMaxChangedRatio = 0.9;
// A less accurate map says nothing about single trees.
constexpr double kMaxWideningM = 20.0;

// Deviation of one map's position against the other's.
double DeviationBetween(const ElevationMap& map, const KeptTerrain& other) {
  return std::hypot(map.position_sd_m, other.position_sd_m);
}

// Greatest height of the cells that may share a block of the other map with this cell. Unseen cells
// do not count.
float HighestAround(const ElevationMap& map, int row, int col, int num_cells) {
  float highest = map.upper(row, col);
  const Grid& grid = map.grid;
  for (int r = std::max(0, row - num_cells); r <= std::min(grid.num_rows - 1, row + num_cells);
       ++r) {
    for (int c = std::max(0, col - num_cells); c <= std::min(grid.num_cols - 1, col + num_cells);
         ++c) {
      highest = std::max(highest, map.upper(r, c));
    }
  }
  return highest;
}

// To be added to heights of the other map, so that it lies nowhere too low on the ground that both
// saw, but where the ground rose since. Nothing if they saw too little in common.
std::optional<double> LevelOf(const ElevationMap& map,
                              const Places& in_other,
                              const KeptTerrain& other) {
  const int block_cells =
      static_cast<int>(std::ceil(other.grid.cell_size_m / map.grid.cell_size_m));
  std::vector<float> differences;
  for (int row = 0; row < map.grid.num_rows; row += kStrideOfCommonCells) {
    for (int col = 0; col < map.grid.num_cols; col += kStrideOfCommonCells) {
      if (std::isnan(map.upper(row, col))) continue;
      const auto block = other.grid.CellAt(in_other(map.grid.CellCenter(row, col)));
      if (!block || other.is_seen(*block) == 0) continue;
      differences.push_back(HighestAround(map, row, col, block_cells) - other.upper(*block));
    }
  }
  if (differences.size() < kMinNumCommonCells) return std::nullopt;
  return ValueAtRank(differences, kMaxChangedRatio);
}

// The same by the maps' altitudes, with the deviations of both.
std::optional<double> LevelByAltitude(const ElevationMap& map,
                                      const GeoPoint& origin,
                                      const AltitudeReference& own,
                                      const OtherGround& other,
                                      double sigma) {
  const DatumDifference datum = DatumDifferenceOf(other.reference, own);
  if (datum.basis != DatumBasis::kSame && datum.basis != DatumBasis::kGeoid) return std::nullopt;
  return other.terrain->origin.altitude_m - origin.altitude_m - datum.subtracted_m +
         sigma * DeviationBetween(map, *other.terrain);
}

// The cells of the other map that lie within `margin` of the map.
cv::Rect CellsWithin(const Grid& grid, const Places& in_other, const Grid& other, double margin) {
  const Eigen::Vector2d size(grid.num_cols * grid.cell_size_m, -grid.num_rows * grid.cell_size_m);
  Polygon outline;
  for (const auto& [right, down] : {std::pair(0.0, 0.0), {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}}) {
    outline.push_back(
        in_other(grid.north_west_in_world + size.cwiseProduct(Eigen::Vector2d(right, down))));
  }
  return other.CellsAround(outline, margin);
}

void AddHeights(const ElevationMap& map,
                const Places& in_other,
                const Grid& blocks,
                const cv::Mat1f& heights,
                float level,
                cv::Mat1f& upper) {
  for (int row = 0; row < map.grid.num_rows; ++row) {
    for (int col = 0; col < map.grid.num_cols; ++col) {
      if (!std::isnan(map.upper(row, col))) continue;
      const auto block = blocks.CellAt(in_other(map.grid.CellCenter(row, col)));
      if (!block || heights(*block) == kNoGround) continue;
      const float top = heights(*block) + level;
      float& highest = upper(row, col);
      if (!(highest >= top)) highest = top;
    }
  }
}

}  // namespace

cv::Mat1f WithGroundOfOthers(const ElevationMap& map,
                             const GeoPoint& origin,
                             const AltitudeReference& own,
                             const std::vector<OtherGround>& others,
                             double sigma) {
  if (others.empty()) return map.upper;
  cv::Mat1f upper = map.upper.clone();
  const LocalFrame frame(origin);
  for (const OtherGround& other : others) {
    const KeptTerrain& terrain = *other.terrain;
    const double widening = sigma * DeviationBetween(map, terrain);
    if (!(widening <= kMaxWideningM)) continue;
    const Places in_other(frame, LocalFrame(terrain.origin), MiddleOf(map.grid));
    std::optional<double> level = LevelOf(map, in_other, terrain);
    if (!level) level = LevelByAltitude(map, origin, own, other, sigma);
    if (!level) continue;
    const int half = static_cast<int>(std::ceil(widening / terrain.grid.cell_size_m));
    const cv::Rect near = CellsWithin(map.grid, in_other, terrain.grid, widening);
    if (near.empty()) continue;
    AddHeights(map,
               in_other,
               terrain.grid.Part(near),
               HighestWithin(terrain.upper(near), half),
               static_cast<float>(*level),
               upper);
  }
  return upper;
}

}  // namespace freelsd
