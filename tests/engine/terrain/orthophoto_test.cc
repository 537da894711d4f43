// Cameras that look straight down on painted ground: the picture must be the paint.
#include <doctest/doctest.h>

#include "engine/terrain/terrain.h"
#include "tests/engine/stereo/scene.h"

namespace freelsd {
namespace {

constexpr double kHeightM = 60.0;

using Paint = std::function<cv::Vec3b(const Eigen::Vector2d& place_in_world)>;

// Level ground at 0 about the origin.
ElevationMap LevelMap(int num_cells, double cell_size_m = 1.0) {
  ElevationMap map;
  const double half_m = 0.5 * num_cells * cell_size_m;
  map.grid = {{-half_m, half_m}, cell_size_m, num_cells, num_cells};
  map.elevation = cv::Mat1f(num_cells, num_cells, 0.0f);
  map.upper = cv::Mat1f(num_cells, num_cells, 0.1f);
  map.standard_deviation = cv::Mat1f(num_cells, num_cells, 0.1f);
  map.num_points = cv::Mat1f(num_cells, num_cells, 50.0f);
  return map;
}

AdjustedBlock BlockOf(const std::vector<Rigid3d>& world_from_camera) {
  AdjustedBlock block;
  block.camera = SceneCamera();
  block.is_usable = true;
  for (const Rigid3d& pose : world_from_camera) {
    AdjustedView view;
    view.frame_id = std::to_string(block.views.size());
    view.world_from_camera = pose;
    view.height_above_ground = pose.translation.z();
    view.is_connected = true;
    block.views.push_back(view);
  }
  return block;
}

// Colour of what a ray from the eye meets.
using RayPaint = std::function<cv::Vec3b(const Eigen::Vector3d& eye, const Eigen::Vector3d& ray)>;

Eigen::Vector2d AtHeight(const Eigen::Vector3d& eye, const Eigen::Vector3d& ray, double height) {
  return (eye - ray * ((eye.z() - height) / ray.z())).head<2>();
}

// What each view of the block shows.
ImageSource ImagesOfRays(const AdjustedBlock& block, const RayPaint& paint) {
  return [&block, paint](const std::string& frame_id) -> cv::Mat {
    const Rigid3d& world_from_camera = block.views[std::stoul(frame_id)].world_from_camera;
    cv::Mat3b image(block.camera.height_px, block.camera.width_px);
    for (int v = 0; v < image.rows; ++v) {
      for (int u = 0; u < image.cols; ++u) {
        image(v, u) =
            paint(world_from_camera.translation,
                  world_from_camera.rotation * block.camera.RayFromImage({double(u), double(v)}));
      }
    }
    return image;
  };
}

ImageSource ImagesOf(const AdjustedBlock& block, const Paint& paint) {
  return ImagesOfRays(block, [paint](const Eigen::Vector3d& eye, const Eigen::Vector3d& ray) {
    return paint(AtHeight(eye, ray, 0.0));
  });
}

// Every view of one colour: its number in blue.
cv::Mat Numbered(const AdjustedBlock& block, const std::string& frame_id) {
  const auto blue = static_cast<double>(10 + 10 * std::stoul(frame_id));
  return cv::Mat3b(block.camera.height_px, block.camera.width_px, cv::Vec3b(uchar(blue), 0, 0));
}

// The view whose number stands there; -1 where the picture is unseen.
int ViewAt(const Orthophoto& photo, double east, double north) {
  const cv::Point cell = *photo.grid.CellAt({east, north});
  return photo.seen(cell) ? (photo.image(cell)[0] - 10) / 10 : -1;
}

std::vector<Rigid3d> TwoNadirViews() {
  return {SceneView({-10.0, 0.0, kHeightM}, 0.3), SceneView({10.0, 0.0, kHeightM}, 2.2)};
}

TEST_CASE("orthophoto: paint comes out where it lies, north up, whichever way the views fly") {
  const Eigen::Vector2d marker(7.0, -5.0);
  const auto paint = [&](const Eigen::Vector2d& place) -> cv::Vec3b {
    if ((place - marker).cwiseAbs().maxCoeff() <= 1.0) return {0, 0, 255};
    return {50, uchar(std::clamp(128.0 + 4.0 * place.y(), 0.0, 255.0)), 0};
  };
  const ElevationMap map = LevelMap(36);
  const AdjustedBlock block = BlockOf(TwoNadirViews());
  const Orthophoto photo = MakeOrthophoto(map, block, ImagesOf(block, paint), {});
  CHECK(photo.grid.cell_size_m == 0.25);
  CHECK(photo.grid.num_rows == 144);
  CHECK(photo.grid.north_west_in_world == map.grid.north_west_in_world);
  CHECK(photo.image.size() == photo.seen.size());
  REQUIRE(cv::countNonZero(photo.seen) == photo.seen.size().area());
  double max_green_error = 0.0;
  for (int row = 0; row < photo.image.rows; ++row) {
    for (int col = 0; col < photo.image.cols; ++col) {
      const Eigen::Vector2d center = photo.grid.CellCenter(row, col);
      const double off = (center - marker).cwiseAbs().maxCoeff();
      const cv::Vec3b& color = photo.image(row, col);
      // Half a cell, and half a pixel.
      if (off < 1.0 - 0.25) CHECK(color[2] > 200);
      if (off < 1.0 + 0.25) continue;
      CHECK(color[2] < 50);
      max_green_error = std::max(max_green_error, std::abs(color[1] - paint(center)[1]) * 1.0);
    }
  }
  CHECK(max_green_error <= 3.0);  // one cell, and both rounded
}

TEST_CASE("orthophoto: heights of the map are where cells are looked for") {
  // 12 m up, seen from 20 m aside: 4 m farther out on the image than the ground below.
  ElevationMap map = LevelMap(20);
  map.elevation.setTo(12.0f);
  const AdjustedBlock block = BlockOf({SceneView({20.0, 0.0, kHeightM}, 0.0)});
  const auto paint = [](const Eigen::Vector2d& place) -> cv::Vec3b {
    return place.x() < -5.0 ? cv::Vec3b(0, 0, 255) : cv::Vec3b(0, 255, 0);
  };
  const Orthophoto photo = MakeOrthophoto(map, block, ImagesOf(block, paint), {});
  // The ray through (0, 0, 12) meets the ground at -5.
  const auto is_red = [&](double east) {
    return photo.image(*photo.grid.CellAt({east, 0.1}))[2] > 127;
  };
  CHECK(is_red(-0.6));
  CHECK_FALSE(is_red(0.6));
}

TEST_CASE("orthophoto: each cell is of the view that looks down on it most steeply") {
  const AdjustedBlock block = BlockOf(TwoNadirViews());
  const auto images = [&](const std::string& id) { return Numbered(block, id); };
  const Orthophoto photo = MakeOrthophoto(LevelMap(36), block, images, {});
  for (const double north : {-15.0, 0.0, 15.0}) {
    CHECK(ViewAt(photo, -14.5, north) == 0);
    CHECK(ViewAt(photo, -1.5, north) == 0);
    CHECK(ViewAt(photo, 1.5, north) == 1);
    CHECK(ViewAt(photo, 14.5, north) == 1);
  }
}

TEST_CASE("orthophoto: unseen cells, unconnected views and empty images stay unseen") {
  ElevationMap map = LevelMap(36);
  map.elevation(10, 10) = std::numeric_limits<float>::quiet_NaN();
  AdjustedBlock block = BlockOf(TwoNadirViews());
  const auto images = [&](const std::string& id) { return Numbered(block, id); };
  const Orthophoto whole = MakeOrthophoto(map, block, images, {});
  CHECK(cv::countNonZero(whole.seen == 0) == 16);
  CHECK(whole.seen(4 * 10, 4 * 10) == 0);
  CHECK(whole.image(4 * 10, 4 * 10) == cv::Vec3b(0, 0, 0));

  block.views[0].is_connected = false;
  const Orthophoto other = MakeOrthophoto(map, block, images, {});
  CHECK(ViewAt(other, -5.0, 0.0) == 1);

  block.views[0].is_connected = true;
  const auto only_second = [&](const std::string& id) {
    return id == "1" ? Numbered(block, id) : cv::Mat();
  };
  const Orthophoto half = MakeOrthophoto(map, block, only_second, {});
  CHECK(ViewAt(half, -14.5, 0.0) == -1);
  CHECK(ViewAt(half, 14.5, 0.0) == 1);
  CHECK(cv::countNonZero(half.image.reshape(1) != 0) <= cv::countNonZero(half.seen));

  block.views[0].is_connected = block.views[1].is_connected = false;
  CHECK(cv::countNonZero(MakeOrthophoto(map, block, images, {}).seen) == 0);
}

TEST_CASE("orthophoto: what lies outside every view is unseen, and an empty map has no picture") {
  const AdjustedBlock block = BlockOf({SceneView({0.0, 0.0, kHeightM}, 0.0)});
  const auto images = [&](const std::string& id) { return Numbered(block, id); };
  const Orthophoto photo = MakeOrthophoto(LevelMap(100), block, images, {});
  CHECK(ViewAt(photo, 0.0, 0.0) == 0);
  CHECK(ViewAt(photo, 27.5, 0.0) == 0);
  CHECK(ViewAt(photo, 29.5, 0.0) == -1);
  CHECK(ViewAt(photo, 0.0, 24.5) == -1);
  CHECK(MakeOrthophoto(ElevationMap{}, block, images, {}).image.empty());
}

TEST_CASE("orthophoto: photographs of twelve megapixels are averaged, not sampled") {
  AdjustedBlock block = BlockOf({SceneView({0.0, 0.0, kHeightM}, 0.0)});
  block.camera.width_px = 4000;
  block.camera.height_px = 3000;
  block.camera.fx_px = block.camera.fy_px = 4200.0;
  block.camera.cx_px = 1999.5;
  block.camera.cy_px = 1499.5;
  // Black and white pixels, as large as 0.014 m on the ground.
  cv::Mat3b checkered(3000, 4000);
  for (int row = 0; row < checkered.rows; ++row) {
    for (int col = 0; col < checkered.cols; ++col) {
      checkered(row, col) = (row + col) % 2 == 0 ? cv::Vec3b(0, 0, 0) : cv::Vec3b(255, 255, 255);
    }
  }
  const Orthophoto photo =
      MakeOrthophoto(LevelMap(20), block, [&](const std::string&) { return checkered; }, {});
  REQUIRE(cv::countNonZero(photo.seen) == photo.seen.size().area());
  double lowest = 0.0, highest = 0.0;
  cv::minMaxLoc(photo.image.reshape(1), &lowest, &highest);
  CHECK(lowest > 110.0);
  CHECK(highest < 145.0);
}

TEST_CASE("orthophoto: grey images give a grey picture") {
  const AdjustedBlock block = BlockOf(TwoNadirViews());
  const auto images = [&](const std::string&) -> cv::Mat {
    return cv::Mat1b(block.camera.height_px, block.camera.width_px, uchar{77});
  };
  const Orthophoto photo = MakeOrthophoto(LevelMap(36), block, images, {});
  CHECK(photo.image(20, 20) == cv::Vec3b(77, 77, 77));
}

TEST_CASE("orthophoto: its cells part those of any map") {
  const AdjustedBlock block = BlockOf({SceneView({0.0, 0.0, kHeightM}, 0.0)});
  const auto images = [&](const std::string& id) { return Numbered(block, id); };
  const Orthophoto fine = MakeOrthophoto(LevelMap(40, 0.1), block, images, {});
  CHECK(fine.grid.cell_size_m == 0.1);
  const Orthophoto third = MakeOrthophoto(LevelMap(10, 0.8), block, images, {});
  CHECK(third.grid.cell_size_m == doctest::Approx(0.8 / 3.0));
  CHECK(third.grid.num_cols == 30);
}

TEST_CASE("orthophoto: cells of no size are refused") {
  TerrainOptions options;
  options.orthophoto_cell_size_m = 0.0;
  CHECK_THROWS_WITH_AS(options.Check(),
                       "terrain.orthophoto_cell_size_m = 0: must be in [0.1, 0.4]",
                       std::invalid_argument);
  options.orthophoto_cell_size_m = std::nan("");
  CHECK_THROWS_AS(options.Check(), std::invalid_argument);
}

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
      if (distance < 2.0)
        CHECK(grown == doctest::Approx(TerrainOptions().narrow_cover_allowance_m));
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
                const TerrainOptions& options = {}) {
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
  TerrainOptions options;
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
  TerrainOptions off;
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
