#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "server/recall/other_maps/other_maps.h"

namespace freelsd {
namespace {

constexpr float kNoGround = -1e30f;
// Cells between two that are compared to level the maps, and the least number of these.
constexpr int kStrideOfCommonCells = 4;
constexpr size_t kMinNumCommonCells = 100;
// Of the common cells, this share may have been higher for the other flight, or lower for this one:
// crops and trees grow and are cut. The ground that both saw unchanged is among the rest, or the
// other map's heights are taken as too high, which is safe.
constexpr double kMaxChangedRatio = 0.9;
// A less accurate map says nothing about single trees.
constexpr double kMaxWideningM = 20.0;

// Horizontal places of one frame in another. The two planes are tangent within kilometres of each
// other, so that the map is affine.
class Places {
 public:
  Places(const LocalFrame& from, const LocalFrame& to, const Eigen::Vector2d& around)
      : around_(around) {
    const auto at = [&](const Eigen::Vector2d& place) -> Eigen::Vector2d {
      GeoPoint geo = from.GeoFromWorld({place.x(), place.y(), 0.0});
      geo.altitude_m = to.origin().altitude_m;
      return to.WorldFromGeo(geo).head<2>();
    };
    shift_ = at(around);
    rotation_.col(0) = (at(around + kStep * Eigen::Vector2d::UnitX()) - shift_) / kStep;
    rotation_.col(1) = (at(around + kStep * Eigen::Vector2d::UnitY()) - shift_) / kStep;
  }
  Eigen::Vector2d operator()(const Eigen::Vector2d& place) const {
    return shift_ + rotation_ * (place - around_);
  }

 private:
  static constexpr double kStep = 100.0;
  Eigen::Vector2d around_, shift_;
  Eigen::Matrix2d rotation_;
};

Eigen::Vector2d MiddleOf(const Grid& grid) {
  return grid.north_west_in_world +
         0.5 * grid.cell_size_m * Eigen::Vector2d(grid.num_cols, -grid.num_rows);
}

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
  const auto rank =
      static_cast<std::ptrdiff_t>(kMaxChangedRatio * static_cast<double>(differences.size() - 1));
  std::nth_element(differences.begin(), differences.begin() + rank, differences.end());
  return differences[static_cast<size_t>(rank)];
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

cv::Mat1f Widened(const cv::Mat1f& upper, int half) {
  cv::Mat1f heights = upper.clone();
  cv::patchNaNs(heights, kNoGround);
  if (half == 0) return heights;
  cv::Mat1f widened;
  cv::dilate(heights,
             widened,
             cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * half + 1, 2 * half + 1}),
             cv::Point(-1, -1),
             1,
             cv::BORDER_CONSTANT,
             cv::Scalar::all(kNoGround));
  return widened;
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
               Widened(terrain.upper(near), half),
               static_cast<float>(*level),
               upper);
  }
  return upper;
}

}  // namespace freelsd
