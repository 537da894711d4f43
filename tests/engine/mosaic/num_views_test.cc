#include <random>

#include <doctest/doctest.h>

#include "engine/mosaic/mosaic.h"
#include "tests/engine/cover/views_from_above.h"

namespace freelsd {
namespace {

using above::BlockOf;
using above::LevelMap;

// Every view at every cell.
cv::Mat1b PlainCounts(const ElevationMap& map, const AdjustedBlock& block) {
  cv::Mat1b counts(map.elevation.size(), uint8_t{0});
  for (int row = 0; row < counts.rows; ++row) {
    for (int col = 0; col < counts.cols; ++col) {
      if (!map.IsSeen(row, col)) continue;
      const Eigen::Vector2d center = map.grid.CellCenter(row, col);
      for (size_t v = 0; v < block.views.size(); ++v) {
        if (!block.views[v].is_connected) continue;
        const Camera camera = block.CameraOf(v);
        const auto pixel = camera.ImageFromCamera(
            Inverse(block.views[v].world_from_camera) *
            Eigen::Vector3d(center.x(), center.y(), map.elevation(row, col)));
        if (pixel && camera.IsInside(*pixel) && counts(row, col) < 255) ++counts(row, col);
      }
    }
  }
  return counts;
}

ElevationMap Hills() {
  ElevationMap map = LevelMap(120);
  for (int row = 0; row < 120; ++row) {
    for (int col = 0; col < 120; ++col) {
      map.elevation(row, col) = 5.0f * std::sin(float(row) / 11.0f) + 0.1f * float(col);
    }
  }
  map.elevation(cv::Rect(50, 30, 20, 7)) = std::numeric_limits<float>::quiet_NaN();
  return map;
}

TEST_CASE("num views: as many as projecting every cell into every view finds") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::vector<Rigid3d> poses;
  for (int i = 0; i < 25; ++i) {
    // Some look at the horizon.
    const double tilt_deg = i % 5 == 0 ? 70.0 : 20.0;
    poses.push_back(SceneView({60.0 * uniform(random), 60.0 * uniform(random), 60.0},
                              kPi * uniform(random),
                              tilt_deg * uniform(random),
                              tilt_deg * uniform(random)));
  }
  AdjustedBlock block = BlockOf(poses);
  block.views[3].is_connected = false;
  block.views[7].readout = Readout::Turning({0.02, -0.01, 0.01});
  block.camera.distortion = DistortionModel::kRadTan;
  block.camera.coefficients = {-0.1, 0.02, 0.001, -0.001};
  const ElevationMap map = Hills();
  const cv::Mat1b counts = NumViewsOf(map, block);
  CHECK(cv::norm(counts, PlainCounts(map, block), cv::NORM_INF) == 0.0);
  CHECK(counts(33, 55) == 0);
  double highest;
  cv::minMaxLoc(counts, nullptr, &highest);
  CHECK(highest >= 5.0);
}

TEST_CASE("num views: at most 255, and none without map or views") {
  const AdjustedBlock block = BlockOf(std::vector<Rigid3d>(300, SceneView({0.0, 0.0, 60.0}, 0.0)));
  const cv::Mat1b counts = NumViewsOf(LevelMap(20), block);
  CHECK(counts(10, 10) == 255);
  CHECK(NumViewsOf(ElevationMap{}, block).empty());
  CHECK(cv::countNonZero(NumViewsOf(LevelMap(20), AdjustedBlock{})) == 0);
}

}  // namespace
}  // namespace freelsd
