#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "server/recall/other_maps/other_maps.h"

namespace freelsd {
namespace {

constexpr float kNoGround = -1e30f;
// Cells between two that are compared to level the maps, and the least number of these.
constexpr int kStrideOfCommonCells = 4;
constexpr size_t kMinNumCommonCells = 100;
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

// To be added to heights of the other map, so that the ground that both saw is level. Nothing if
// they saw too little in common.
std::optional<double> LevelOf(const ElevationMap& map,
                              const Places& in_other,
                              const KeptTerrain& other) {
  std::vector<float> differences;
  for (int row = 0; row < map.grid.num_rows; row += kStrideOfCommonCells) {
    for (int col = 0; col < map.grid.num_cols; col += kStrideOfCommonCells) {
      const float height = map.upper(row, col);
      if (std::isnan(height)) continue;
      const auto block = other.grid.CellAt(in_other(map.grid.CellCenter(row, col)));
      if (block && other.is_seen(*block) != 0) differences.push_back(height - other.upper(*block));
    }
  }
  if (differences.size() < kMinNumCommonCells) return std::nullopt;
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  return *middle;
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

cv::Mat1f Widened(const KeptTerrain& terrain, double radius) {
  cv::Mat1f heights = terrain.upper.clone();
  cv::patchNaNs(heights, kNoGround);
  const int half = static_cast<int>(std::ceil(radius / terrain.grid.cell_size_m));
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
    AddHeights(
        map, in_other, terrain.grid, Widened(terrain, widening), static_cast<float>(*level), upper);
  }
  return upper;
}

}  // namespace freelsd
