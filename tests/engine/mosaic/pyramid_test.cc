#include "engine/mosaic/pyramid.h"

#include <array>
#include <atomic>
#include <map>
#include <set>

#include <doctest/doctest.h>

#include "tests/engine/cover/views_from_above.h"
#include "tests/engine/mosaic/kept_tiles.h"

namespace freelsd {
namespace {

MosaicLattice LatticeOf(const cv::Rect& tiles, int num_levels) {
  MosaicLattice lattice;
  lattice.pixel_size_m = 1.0;
  lattice.tile_size_px = 2;
  lattice.num_levels = num_levels;
  lattice.tiles = tiles;
  return lattice;
}

TEST_CASE("mosaic pyramid: transparent pixels have no colour, and alpha is the shown share") {
  const cv::Vec4b none(0, 0, 0, 0), red(0, 0, 200, 255), blue(100, 0, 0, 255);
  cv::Mat4b quarter(2, 2, none);
  cv::Mat4b quarters[4];
  quarters[1] = (cv::Mat4b(2, 2) << red, none, none, none);
  quarters[2] = (cv::Mat4b(2, 2) << red, blue, none, none);
  const cv::Mat4b halved = HalvedTile(quarters, 2);
  CHECK(halved(0, 0) == none);
  CHECK(halved(0, 1) == cv::Vec4b(0, 0, 200, 64));
  CHECK(halved(1, 0) == cv::Vec4b(50, 0, 100, 128));
  CHECK(halved(1, 1) == none);
  const cv::Mat4b nothing[4];
  CHECK(HalvedTile(nothing, 2).empty());
}

TEST_CASE("mosaic pyramid: neighbours follow each other, and a coarse tile comes after its four") {
  std::vector<cv::Point> finest;
  std::set<std::array<int, 3>> kept;
  std::atomic<int> num_painted = 0;
  const auto paint = [&](int, int) {
    ++num_painted;
    return cv::Mat4b(2, 2, cv::Vec4b(1, 2, 3, 255));
  };
  const auto keep = [&](const MosaicTile& tile) {
    if (tile.level == 0) finest.emplace_back(tile.col, tile.row);
    CHECK(kept.insert({tile.level, tile.row, tile.col}).second);
    for (int i = 0; tile.level > 0 && i < 4; ++i) {
      CHECK(kept.count({tile.level - 1, 2 * tile.row + i / 2, 2 * tile.col + i % 2}) == 1);
    }
  };
  CHECK(BuildPyramid(LatticeOf({-8, 8, 8, 8}, 4), paint, keep) == 64 + 16 + 4 + 1);
  CHECK(num_painted == 64);
  REQUIRE(finest.size() == 64);
  for (size_t i = 1; i < finest.size(); ++i) {
    const cv::Point step = finest[i] - finest[i - 1];
    CHECK(std::abs(step.x) + std::abs(step.y) == 1);
  }
}

TEST_CASE("mosaic pyramid: only tiles that the map touches are painted") {
  std::atomic<int> num_painted = 0, num_outside = 0;
  const auto paint = [&](int row, int col) {
    num_outside += cv::Rect(-1, -1, 3, 2).contains({col, row}) ? 0 : 1;
    ++num_painted;
    return row < 0 ? cv::Mat4b() : cv::Mat4b(2, 2, cv::Vec4b(1, 2, 3, 255));
  };
  std::map<int, int> num_kept;
  const auto keep = [&](const MosaicTile& tile) { ++num_kept[tile.level]; };
  BuildPyramid(LatticeOf({-1, -1, 3, 2}, 3), paint, keep);
  CHECK(num_painted == 6);
  CHECK(num_outside == 0);
  CHECK(num_kept[0] == 3);
  // The tiles north of the origin are empty at every level.
  CHECK(num_kept[1] == 2);
  CHECK(num_kept[2] == 2);
}

TEST_CASE("mosaic pyramid: each level shows the same ground") {
  const AdjustedBlock block = above::BlockOf(above::TwoNadirViews());
  const auto paint = [](const Eigen::Vector2d& place) -> cv::Vec3b {
    return {cv::saturate_cast<uint8_t>(128.0 + 4.0 * place.x()),
            cv::saturate_cast<uint8_t>(128.0 + 4.0 * place.y()),
            50};
  };
  MosaicOptions options;
  options.tile_size_px = 64;
  const KeptTiles kept = Kept(above::LevelMap(36), block, above::ImagesOf(block, paint), options);
  REQUIRE(kept.report.lattice.num_levels == 3);
  for (const Eigen::Vector2d& place : {Eigen::Vector2d(-9.3, 4.1), {7.7, -12.2}, {-3.1, -8.8}}) {
    for (int level = 0; level < 3; ++level) {
      const cv::Vec4b color = kept.At(place, level);
      CHECK(color[3] == 255);
      // Half a pixel of level 2.
      for (int c = 0; c < 2; ++c) CHECK(std::abs(color[c] - paint(place)[c]) <= 3);
    }
  }
}

}  // namespace
}  // namespace freelsd
