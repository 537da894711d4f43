// The mosaic must be the ground.
#include "engine/mosaic/mosaic.h"

#include <doctest/doctest.h>

#include "tests/engine/cover/views_from_above.h"
#include "tests/engine/mosaic/kept_tiles.h"

namespace freelsd {
namespace {

using above::BlockOf;
using above::ImagesOf;
using above::kHeightM;
using above::LevelMap;
using above::Paint;
using above::TwoNadirViews;

// Waves of several metres, so that a shift by a pixel changes the colour by a few grey levels only.
cv::Vec3b Waves(const Eigen::Vector2d& place) {
  return {cv::saturate_cast<uint8_t>(128.0 + 60.0 * std::sin(place.x() / 1.5)),
          cv::saturate_cast<uint8_t>(128.0 + 60.0 * std::cos(place.y() / 1.2)),
          cv::saturate_cast<uint8_t>(120.0 + 40.0 * std::sin((place.x() + place.y()) / 4.0))};
}

// Each photograph brighter or darker than the last.
ImageSource Exposed(const ImageSource& images, double factor) {
  return [images, factor](const std::string& frame_id) -> cv::Mat {
    cv::Mat image = images(frame_id);
    return frame_id == "0" ? image : cv::Mat(image * factor);
  };
}

double MeanDifference(const cv::Vec4b& color, const cv::Vec3b& truth) {
  return (std::abs(color[0] - truth[0]) + std::abs(color[1] - truth[1]) +
          std::abs(color[2] - truth[2])) /
         3.0;
}

TEST_CASE("mosaic: the picture is the ground, whichever way the views fly") {
  const ElevationMap map = LevelMap(36);
  const AdjustedBlock block = BlockOf(TwoNadirViews());
  const KeptTiles kept = Kept(map, block, ImagesOf(block, Waves));
  // 60 m / 400 px = 0.15 m: seven pixels a cell would be finer by 5 %.
  CHECK(kept.report.lattice.pixel_size_m == doctest::Approx(1.0 / 6.0));
  double sum = 0.0, largest = 0.0;
  int count = 0;
  ForEachPixel(kept, 18.0, [&](const Eigen::Vector2d& place, const cv::Vec4b& color) {
    REQUIRE(color[3] == 255);
    const double difference = MeanDifference(color, Waves(place));
    sum += difference;
    largest = std::max(largest, difference);
    ++count;
  });
  CHECK(count == 216 * 216);
  constexpr double kMaxMeanDifference = 1.0, kMaxDifference = 4.0;  // grey levels
  CHECK(sum / count < kMaxMeanDifference);
  CHECK(largest < kMaxDifference);
}

TEST_CASE("mosaic: hills do not move what lies on them, and no step shows between cells") {
  Scene scene;
  scene.camera = SceneCamera();
  scene.height = [](double east, double north) {
    return 4.0 + 3.0 * std::sin(east / 9.0) + 2.0 * std::cos(north / 7.0);
  };
  scene.noise_sd_grey = 0.0;
  std::vector<Rigid3d> poses;
  for (const double east : {-12.0, 0.0, 12.0}) {
    poses.push_back(SceneView({east, 3.0, 64.0}, 0.4, 3.0, -4.0));
  }
  const AdjustedBlock block = SceneBlock(scene, poses);
  ElevationMap map = LevelMap(40);
  for (int row = 0; row < 40; ++row) {
    for (int col = 0; col < 40; ++col) {
      const Eigen::Vector2d center = map.grid.CellCenter(row, col);
      map.elevation(row, col) = static_cast<float>(scene.height(center.x(), center.y()));
    }
  }
  const auto images = [&](const std::string& id) {
    return Render(scene, poses[std::stoul(id)], 1);
  };
  const KeptTiles kept = Kept(map, block, images);
  double sum = 0.0;
  int count = 0;
  ForEachPixel(kept, 15.0, [&](const Eigen::Vector2d& place, const cv::Vec4b& color) {
    if (color[3] == 0) return;
    sum += std::abs(color[1] - scene.texture.At(place.x(), place.y()));
    ++count;
  });
  CHECK(count > 30000);
  // The texture changes by 10 grey levels a pixel.
  constexpr double kMaxMeanDifference = 3.0;
  CHECK(sum / count < kMaxMeanDifference);
}

TEST_CASE("mosaic: two exposures leave no step") {
  const ElevationMap map = LevelMap(36);
  const AdjustedBlock block = BlockOf(TwoNadirViews());
  const auto grey = [](const Eigen::Vector2d& place) -> cv::Vec3b {
    return cv::Vec3b::all(cv::saturate_cast<uint8_t>(100.0 + 10.0 * std::sin(place.y())));
  };
  const KeptTiles kept = Kept(map, block, Exposed(ImagesOf(block, grey), 1.4));
  CHECK(kept.report.step_photographed > 30.0);
  CHECK(kept.report.step_with_gains < 1.0);
  CHECK(kept.report.step_blended < 1.0);
  const cv::Vec3d product = kept.report.gains[0].mul(kept.report.gains[1]);
  for (int c = 0; c < 3; ++c) {
    CHECK(product[c] == doctest::Approx(1.0).epsilon(0.001));
    // The rest is taken for a trend.
    CHECK(kept.report.gains[0][c] / kept.report.gains[1][c] > 1.25);
    CHECK(kept.report.gains[0][c] / kept.report.gains[1][c] < 1.45);
  }
  double largest = 0.0;
  const double pixel_m = kept.report.lattice.pixel_size_m;
  ForEachPixel(kept, 17.0, [&](const Eigen::Vector2d& place, const cv::Vec4b& color) {
    const cv::Vec4b east = kept.At(place + Eigen::Vector2d(pixel_m, 0.0));
    largest = std::max(largest, std::abs(color[1] - east[1]) * 1.0);
  });
  CHECK(largest <= 2.0);
}

TEST_CASE("mosaic: seams go around what views show differently") {
  // A red square floats above the ground, where no map could show it. The ground halfway between
  // the cameras lies in the middle of what the western view shows of it.
  const ElevationMap map = LevelMap(40);
  const AdjustedBlock block =
      BlockOf({SceneView({-9.0, 0.0, kHeightM}, 0.0), SceneView({9.0, 0.0, kHeightM}, 0.0)});
  const auto images = above::ImagesOfRays(
      block, [](const Eigen::Vector3d& eye, const Eigen::Vector3d& ray) -> cv::Vec3b {
        const Eigen::Vector2d place = above::AtHeight(eye, ray, 8.0);
        const bool is_square = (place - Eigen::Vector2d(-1.2, 0.0)).cwiseAbs().maxCoeff() < 1.0;
        return is_square ? cv::Vec3b(0, 0, 255) : cv::Vec3b(80, 120, 80);
      });
  const auto red_m2 = [&](int max_num_rounds) {
    MosaicOptions options;
    options.max_num_rounds = max_num_rounds;
    const KeptTiles kept = Kept(map, block, images, options);
    int num_red = 0;
    ForEachPixel(kept, 10.0, [&](const Eigen::Vector2d&, const cv::Vec4b& color) {
      num_red += color[2] > 160;
    });
    return num_red * kept.report.lattice.pixel_size_m * kept.report.lattice.pixel_size_m;
  };
  // Projected onto the ground.
  const double whole_m2 = std::pow(2.0 * kHeightM / (kHeightM - 8.0), 2.0);
  CHECK(red_m2(0) > 0.2 * whole_m2);
  CHECK(red_m2(0) < 0.8 * whole_m2);
  const double shown_ratio = red_m2(3) / whole_m2;
  CHECK((shown_ratio < 0.03 || std::abs(shown_ratio - 1.0) < 0.1));
}

TEST_CASE("mosaic: the same bytes with any tile size, cache, and number of threads") {
  const ElevationMap map = LevelMap(40);
  const AdjustedBlock block = BlockOf(TwoNadirViews());
  const auto images = Exposed(ImagesOf(block, Waves), 0.8);
  MosaicOptions options;
  options.tile_size_px = 64;
  const KeptTiles small = Kept(map, block, images, options);
  options.max_cache_mb = 0.0;
  cv::setNumThreads(1);
  const KeptTiles again = Kept(map, block, images, options);
  cv::setNumThreads(-1);
  options.tile_size_px = 256;
  const KeptTiles large = Kept(map, block, images, options);
  CHECK(small.images.size() > large.images.size());
  int num_different = 0, num_different_again = 0;
  ForEachPixel(small, 22.0, [&](const Eigen::Vector2d& place, const cv::Vec4b& color) {
    num_different += color != large.At(place);
    num_different_again += color != again.At(place);
  });
  CHECK(num_different == 0);
  CHECK(num_different_again == 0);
}

TEST_CASE("mosaic: a missing image leaves its ground to other views") {
  const ElevationMap map = LevelMap(36);
  const AdjustedBlock block = BlockOf(TwoNadirViews());
  const auto all = ImagesOf(block, Waves);
  const auto images = [&](const std::string& id) { return id == "1" ? cv::Mat() : all(id); };
  const KeptTiles kept = Kept(map, block, images);
  CHECK(kept.report.num_missing_images == 1);
  CHECK(kept.At({-14.0, 0.0})[3] == 255);
  CHECK(kept.At({8.0, 0.0})[3] == 255);
  double lowest, highest;
  cv::minMaxLoc(kept.report.view, &lowest, &highest);
  CHECK(highest == 0.0);
  const auto of_another_size = [&](const std::string& id) {
    return id == "1" ? cv::Mat(cv::Mat3b(30, 40)) : all(id);
  };
  CHECK(Kept(map, block, of_another_size).report.num_missing_images == 1);
  CHECK(Kept(map, block, [](const std::string&) { return cv::Mat(); }).images.empty());
}

TEST_CASE("mosaic: nothing comes of an empty map or without views") {
  const AdjustedBlock block = BlockOf(TwoNadirViews());
  const auto images = ImagesOf(block, Waves);
  CHECK(Kept(ElevationMap{}, block, images).images.empty());
  CHECK(Kept(LevelMap(36), AdjustedBlock{}, images).images.empty());
  AdjustedBlock unconnected = block;
  for (AdjustedView& view : unconnected.views) view.is_connected = false;
  CHECK(PlanMosaic(LevelMap(36), unconnected, {}).num_levels == 0);
  CHECK(Kept(LevelMap(36), unconnected, images).images.empty());
  ElevationMap unseen = LevelMap(36);
  unseen.elevation.setTo(std::numeric_limits<float>::quiet_NaN());
  CHECK(Kept(unseen, block, images).images.empty());
}

TEST_CASE("mosaic: one view alone is shown as it is, grey images give a grey picture") {
  const AdjustedBlock block = BlockOf({SceneView({0.0, 0.0, kHeightM}, 0.0)});
  const auto images = [&](const std::string&) -> cv::Mat {
    return cv::Mat1b(block.camera.height_px, block.camera.width_px, uint8_t{77});
  };
  const KeptTiles kept = Kept(LevelMap(100), block, images);
  CHECK(kept.At({0.0, 0.0}) == cv::Vec4b(77, 77, 77, 255));
  CHECK(kept.At({27.0, 0.0}) == cv::Vec4b(77, 77, 77, 255));
  // Beyond the image.
  CHECK(kept.At({29.5, 0.0})[3] == 0);
  CHECK(kept.At({0.0, 24.5})[3] == 0);
}

TEST_CASE("mosaic: small holes of the map are filled, large ones and the outside are transparent") {
  ElevationMap map = LevelMap(36);
  const float unseen = std::numeric_limits<float>::quiet_NaN();
  map.elevation(cv::Rect(10, 10, 3, 3)) = unseen;
  map.elevation(cv::Rect(20, 16, 9, 9)) = unseen;
  const AdjustedBlock block = BlockOf(TwoNadirViews());
  const KeptTiles kept = Kept(map, block, ImagesOf(block, Waves));
  const Eigen::Vector2d small = map.grid.CellCenter(11, 11);
  CHECK(kept.At(small)[3] == 255);
  CHECK(MeanDifference(kept.At(small + Eigen::Vector2d(0.01, 0.01)), Waves(small)) < 12.0);
  CHECK(kept.At(map.grid.CellCenter(20, 24))[3] == 0);
  CHECK(kept.At({18.5, 0.0})[3] == 0);
  MosaicOptions options;
  options.max_hole_m = 0.0;
  const KeptTiles open = Kept(map, block, ImagesOf(block, Waves), options);
  CHECK(open.At(small)[3] == 0);
}

}  // namespace
}  // namespace freelsd
