#include "engine/cover/open_cover.h"

#include <doctest/doctest.h>

#include "tests/engine/cover/views_from_above.h"

namespace freelsd {
namespace {

using above::AtHeight;
using above::BlockOf;
using above::ImagesOfRays;
using above::kHeightM;
using above::LevelMap;
using above::TwoNadirViews;

// Views over a mottled meadow; with twigs `height` above a disc about the origin, if that is more
// than 0: dark squares of 0.7 m in no order, the others open.
ImageSource MeadowWithTwigs(const AdjustedBlock& block, double height, double radius_m = 4.0) {
  return ImagesOfRays(
      block, [=](const Eigen::Vector3d& eye, const Eigen::Vector3d& ray) -> cv::Vec3b {
        const Eigen::Vector2d ground = AtHeight(eye, ray, 0.0), twig = AtHeight(eye, ray, height);
        const auto cell = [](double x) { return static_cast<int>(std::floor(x / 0.7)); };
        const int east = cell(twig.x()), north = cell(twig.y());
        const bool is_twig = (5 * east * east + 3 * north + east * north) % 3 == 0;
        if (height > 0.0 && twig.norm() < radius_m && is_twig) return {25, 35, 40};
        const double mottle = std::sin(2.0 * ground.x()) * std::sin(1.7 * ground.y());
        const auto green = uchar(std::lround(120.0 + 30.0 * mottle));
        return {uchar(green / 2), green, uchar(green / 2)};
      });
}

// How many cells of the map within a distance of the origin have an unknown deviation.
int NumUnknown(const ElevationMap& map, double radius_m) {
  int num_unknown = 0;
  for (int row = 0; row < map.grid.num_rows; ++row) {
    for (int col = 0; col < map.grid.num_cols; ++col) {
      const bool is_near = map.grid.CellCenter(row, col).norm() < radius_m;
      num_unknown += is_near && std::isnan(map.standard_deviation(row, col));
    }
  }
  return num_unknown;
}

void MarkOpenCover(const Orthophoto& photo,
                   const cv::Mat1b& is_clear_class,
                   const cv::Mat1b& is_meadow,
                   const cv::Mat1b& objects,
                   const PhotoOptions& options,
                   ElevationMap& map) {
  const MeadowCells cells{is_clear_class, is_meadow, objects};
  map = WithCover(map, FindOpenCover(PhotoDisagreement(photo, map.grid), map.grid, cells, options));
}

// Nothing is known to be grass.
cv::Mat1b NoClass(const ElevationMap& map) { return cv::Mat1b::zeros(map.elevation.size()); }

TEST_CASE(
    "open cover: where twigs move against the ground its height is unknown, meadow keeps it") {
  const AdjustedBlock block = BlockOf(TwoNadirViews());
  ElevationMap map = LevelMap(36);
  const Orthophoto photo = MakeOrthophoto(map, block, MeadowWithTwigs(block, 6.0), {});
  REQUIRE(photo.second_image.size() == photo.image.size());
  ElevationMap grass = map;
  grass.standard_deviation = map.standard_deviation.clone();
  MarkOpenCover(photo, NoClass(map), NoClass(map), {}, {}, map);
  CHECK(map.is_compared);
  CHECK(NumUnknown(map, 3.0) == 32);  // all of them
  CHECK(NumUnknown(map, 11.0) == NumUnknown(map, 9.0));
  MarkOpenCover(photo, NoClass(map) + 255, NoClass(map) + 255, {}, {}, grass);
  CHECK(NumUnknown(grass, 11.0) == 0);
}

TEST_CASE("open cover: over a crown too small to be told from an edge the upper height grows") {
  const AdjustedBlock block = BlockOf(TwoNadirViews());
  ElevationMap map = LevelMap(36);
  const cv::Mat1f before = map.upper.clone();
  MarkOpenCover(MakeOrthophoto(map, block, MeadowWithTwigs(block, 3.0, 1.2), {}),
                NoClass(map),
                NoClass(map),
                {},
                {},
                map);
  CHECK(NumUnknown(map, 10.0) == 0);
  for (int row = 0; row < 36; ++row) {
    for (int col = 0; col < 36; ++col) {
      const double distance = map.grid.CellCenter(row, col).norm();
      const float grown = map.upper(row, col) - before(row, col);
      if (distance < 2.0) CHECK(grown == doctest::Approx(PhotoOptions().narrow_cover_allowance_m));
      if (distance > 5.0) CHECK(grown == 0.0f);
    }
  }
}

// Meadow but for a disc about the middle, of which nothing is known.
cv::Mat1b MeadowAround(const ElevationMap& map, double radius_m) {
  cv::Mat1b is_meadow = NoClass(map) + 255;
  for (int row = 0; row < is_meadow.rows; ++row) {
    for (int col = 0; col < is_meadow.cols; ++col) {
      if (map.grid.CellCenter(row, col).norm() < radius_m) is_meadow(row, col) = 0;
    }
  }
  return is_meadow;
}

// By how much the upper height of the middle grows over crown and objects, and that of what is far.
struct Growth {
  float middle = 0.0f;
  float far = 0.0f;
};
Growth GrowthBy(double crown_m,
                const cv::Mat1b& is_meadow,
                const cv::Rect& object,
                const cv::Mat1b& is_clear_class,
                const PhotoOptions& options = {}) {
  const AdjustedBlock block = BlockOf(TwoNadirViews());
  ElevationMap map = LevelMap(36);
  const cv::Mat1f before = map.upper.clone();
  cv::Mat1b objects = NoClass(map);
  objects(object).setTo(uint8_t{255});
  const ImageSource images = MeadowWithTwigs(block, crown_m, 1.2);
  const Orthophoto photo = MakeOrthophoto(map, block, images, {});
  MarkOpenCover(photo, is_clear_class, is_meadow, objects, options, map);
  return {map.upper(18, 18) - before(18, 18), map.upper(18, 30) - before(18, 30)};
}

Growth GrowthBy(double crown_m, const cv::Mat1b& is_meadow, const cv::Rect& object) {
  return GrowthBy(crown_m, is_meadow, object, is_meadow);
}

TEST_CASE("open cover: what stands alone in a meadow may be a sapling that cannot be measured") {
  const ElevationMap map = LevelMap(36);
  const cv::Mat1b meadow = MeadowAround(map, 3.5);
  const cv::Rect nothing, sapling(18, 18, 2, 1);
  // A crown of twigs; a thing of which the picture tells no more than that it is there.
  CHECK(GrowthBy(3.0, meadow, nothing).middle == doctest::Approx(4.0));
  CHECK(GrowthBy(0.0, MeadowAround(map, 1.5), sapling).middle == doctest::Approx(4.0));
  CHECK(GrowthBy(0.0, MeadowAround(map, 1.5), sapling).far == 0.0f);
  // With something else than meadow around it, and if it is part of something wide.
  CHECK(GrowthBy(0.0, MeadowAround(map, 6.0), sapling).middle == 0.0f);
  CHECK(GrowthBy(0.0, MeadowAround(map, 1.5), {12, 18, 12, 1}).middle == 0.0f);
  CHECK(GrowthBy(0.0, meadow, nothing).middle == 0.0f);
}

TEST_CASE("open cover: a fence beside a sapling leaves it alone in its meadow") {
  const ElevationMap map = LevelMap(36);
  const cv::Mat1b meadow = MeadowAround(map, 1.5);
  cv::Mat1b but_for_fence = meadow.clone();
  but_for_fence.row(16).setTo(uint8_t{0});
  but_for_fence.row(20).setTo(uint8_t{0});
  const cv::Rect sapling(18, 18, 1, 1);
  CHECK(GrowthBy(0.0, meadow, sapling, but_for_fence).middle == doctest::Approx(4.0));
  CHECK(GrowthBy(0.0, but_for_fence, sapling, but_for_fence).middle == 0.0f);
}

TEST_CASE("open cover: what stands alone never gets less than other narrow cover") {
  const ElevationMap map = LevelMap(36);
  const cv::Mat1b meadow = MeadowAround(map, 3.5);
  PhotoOptions options;
  options.lone_allowance_m = 0.0;
  CHECK(GrowthBy(3.0, meadow, {}, meadow, options).middle ==
        doctest::Approx(options.narrow_cover_allowance_m));
}

TEST_CASE("open cover: what lies at the map's height is the same in both, however mottled") {
  const AdjustedBlock block = BlockOf(TwoNadirViews());
  ElevationMap map = LevelMap(36);
  MarkOpenCover(MakeOrthophoto(map, block, MeadowWithTwigs(block, 0.0), {}),
                NoClass(map),
                NoClass(map),
                {},
                {},
                map);
  CHECK(NumUnknown(map, 11.0) == 0);
}

TEST_CASE("open cover: one darker photograph is no disagreement") {
  const AdjustedBlock block = BlockOf(TwoNadirViews());
  const ImageSource even = MeadowWithTwigs(block, 0.0);
  const ImageSource one_darker = [&](const std::string& id) -> cv::Mat {
    return id == "1" ? cv::Mat(0.8 * even(id)) : even(id);
  };
  ElevationMap map = LevelMap(36);
  MarkOpenCover(
      MakeOrthophoto(map, block, one_darker, {}), NoClass(map), NoClass(map), {}, {}, map);
  CHECK(NumUnknown(map, 10.0) == 0);
}

TEST_CASE("open cover: ground that one place alone shows is unknown, nothing is compared with 0") {
  const AdjustedBlock near =
      BlockOf({SceneView({0.0, 0.0, kHeightM}, 0.3), SceneView({3.0, 0.0, kHeightM}, 0.3)});
  ElevationMap map = LevelMap(20);
  MarkOpenCover(MakeOrthophoto(map, near, MeadowWithTwigs(near, 0.0), {}),
                NoClass(map),
                NoClass(map),
                {},
                {},
                map);
  CHECK(map.is_compared);
  CHECK(NumUnknown(map, 20.0) == 400);
  PhotoOptions off;
  off.max_photo_disagreement = 0.0;
  ElevationMap same = LevelMap(20);
  const Orthophoto photo = MakeOrthophoto(same, near, MeadowWithTwigs(near, 6.0), off);
  CHECK(photo.second_image.empty());
  MarkOpenCover(photo, NoClass(same), NoClass(same), {}, off, same);
  CHECK_FALSE(same.is_compared);
  CHECK(NumUnknown(same, 20.0) == 0);
}

TEST_CASE("open cover: the rim of a crown whose rest was not seen counts, alone it would not") {
  const AdjustedBlock block = BlockOf(TwoNadirViews());
  // Of the crown only its easternmost two metres are on the map; its other side is away.
  ElevationMap map = LevelMap(36);
  for (int row = 0; row < 36; ++row) {
    for (int col = 0; col < 36; ++col) {
      const Eigen::Vector2d place = map.grid.CellCenter(row, col);
      if (place.x() > 2.0) continue;
      for (cv::Mat1f* raster : {&map.elevation, &map.upper, &map.standard_deviation}) {
        (*raster)(row, col) = std::numeric_limits<float>::quiet_NaN();
      }
    }
  }
  const auto num_unknown_of_seen = [&](const ElevationMap& marked) {
    int num_unknown = 0;
    for (int row = 14; row < 22; ++row) {
      num_unknown += std::isnan(marked.standard_deviation(row, 20));  // 2 to 3 m east
    }
    return num_unknown;
  };
  const ImageSource images = MeadowWithTwigs(block, 6.0);
  ElevationMap rim = map;
  rim.standard_deviation = map.standard_deviation.clone();
  MarkOpenCover(MakeOrthophoto(rim, block, images, {}), NoClass(rim), NoClass(rim), {}, {}, rim);
  CHECK(num_unknown_of_seen(rim) >= 4);
}

}  // namespace
}  // namespace freelsd
