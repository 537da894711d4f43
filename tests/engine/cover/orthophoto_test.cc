// The picture must be the paint.
#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include "tests/engine/camera.h"
#include "tests/engine/cover/views_from_above.h"

namespace freelsd {
namespace {

using above::BlockOf;
using above::ImagesOf;
using above::kHeightM;
using above::LevelMap;
using above::Paint;
using above::TwoNadirViews;

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

// Whether the view shows the four corners of the cell, at the cell's height.
bool IsShown(const ElevationMap& map, const AdjustedBlock& block, size_t view, cv::Point cell) {
  const Rigid3d camera_from_world = Inverse(block.views[view].world_from_camera);
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(-0.5, -0.5),
                                        Eigen::Vector2d(-0.5, 0.5),
                                        Eigen::Vector2d(0.5, -0.5),
                                        Eigen::Vector2d(0.5, 0.5)}) {
    Eigen::Vector3d place;
    place << map.grid.CellCenter(cell.y, cell.x) + corner, map.elevation(cell);
    const auto pixel = block.CameraOf(view).ImageFromCamera(camera_from_world * place);
    if (!pixel || !block.camera.IsInside(*pixel)) return false;
  }
  return true;
}

// Every view against every cell.
int SteepestOf(const ElevationMap& map, const AdjustedBlock& block, cv::Point cell) {
  int steepest = -1;
  double least = 1e12;
  for (size_t v = 0; v < block.views.size(); ++v) {
    const Eigen::Vector2d eye = block.views[v].world_from_camera.translation.head<2>();
    const double distance = (map.grid.CellCenter(cell.y, cell.x) - eye).norm();
    if (distance >= least || !IsShown(map, block, v, cell)) continue;
    least = distance;
    steepest = static_cast<int>(v);
  }
  return steepest;
}

TEST_CASE("orthophoto: of many views, each cell is taken from the steepest that shows it whole") {
  ElevationMap map = LevelMap(150);
  std::vector<Rigid3d> views;
  views.reserve(42);
  for (int row = 0; row < 6; ++row) {
    for (int col = 0; col < 7; ++col) {
      views.push_back(
          SceneView({-110.0 + 37.3 * col, -95.0 + 41.7 * row, kHeightM}, 4.9 * row + 0.7 * col));
    }
  }
  for (int row = 0; row < 150; ++row) {
    for (int col = 0; col < 150; ++col) {
      map.elevation(row, col) = 15.0f * std::sin(0.05f * float(row)) * std::cos(0.07f * float(col));
    }
  }
  map.elevation(70, 70) = std::numeric_limits<float>::quiet_NaN();
  const AdjustedBlock block = BlockOf(views);
  cv::Mat grey(block.camera.height_px, block.camera.width_px, CV_8U, cv::Scalar(128));
  const Orthophoto photo = MakeOrthophoto(map, block, [&](const std::string&) { return grey; }, {});
  int num_views = 0, num_without = 0, num_wrong = 0;
  for (int row = 0; row < 150; ++row) {
    for (int col = 0; col < 150; ++col) {
      const int expected = map.IsSeen(row, col) ? SteepestOf(map, block, {col, row}) : -1;
      num_wrong += photo.view(row, col) != expected;
      num_without += expected < 0;
      num_views = std::max(num_views, expected);
    }
  }
  CHECK(num_wrong == 0);
  CHECK(num_views > 20);
  CHECK(num_without > 1);
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
  block.camera = CenteredCamera(4000, 3000, 4200.0);
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
  PhotoOptions options;
  options.orthophoto_cell_size_m = 0.0;
  CHECK_THROWS_WITH_AS(options.Check(),
                       "terrain.orthophoto_cell_size_m = 0: must be in [0.1, 0.4]",
                       std::invalid_argument);
  options.orthophoto_cell_size_m = std::nan("");
  CHECK_THROWS_AS(options.Check(), std::invalid_argument);
}
}  // namespace
}  // namespace freelsd
