#include "engine/tracks/corners.h"

#include <doctest/doctest.h>

#include "tests/engine/tracks/textured_plane.h"

namespace freelsd {
namespace {

cv::Mat1b Photograph(cv::Size size, unsigned seed) {
  Camera camera;
  camera.width_px = size.width;
  camera.height_px = size.height;
  camera.fx_px = camera.fy_px = size.width;
  camera.cx_px = 0.5 * size.width;
  camera.cy_px = 0.5 * size.height;
  // Looks straight down.
  const Rigid3d world_from_camera{
      Eigen::Quaterniond(Eigen::AngleAxisd(CV_PI, Eigen::Vector3d::UnitX())), {0.0, 0.0, 100.0}};
  return TexturedPlane(120.0, seed).Photograph(camera, world_from_camera);
}

std::vector<cv::Point> OfOpenCv(const cv::Mat1b& grey, const CornerWish& wish) {
  std::vector<cv::Point2f> found;
  cv::goodFeaturesToTrack(
      grey, found, wish.max_count, wish.min_quality, wish.min_distance_px, wish.mask);
  return {found.begin(), found.end()};
}

TEST_CASE("corners are those of OpenCV, in the same order") {
  for (const cv::Size size : {cv::Size(320, 240), cv::Size(161, 97), cv::Size(20, 200)}) {
    for (const double min_distance_px : {1.0, 4.5, 19.0}) {
      CAPTURE(size.width);
      CAPTURE(min_distance_px);
      const cv::Mat1b grey = Photograph(size, static_cast<unsigned>(size.height));
      cv::Mat1b mask(size, uint8_t{255});
      cv::circle(mask, {size.width / 3, size.height / 3}, 15, 0, cv::FILLED);
      const CornerWish wish{mask, 200, 0.002, min_distance_px};
      const std::vector<cv::Point> ours = StrongestCorners(grey, wish);
      REQUIRE(!ours.empty());
      CHECK(ours == OfOpenCv(grey, wish));
    }
  }
}

TEST_CASE("corners: none in an even image, in a tiny one, or where none are wanted") {
  const auto all = [](cv::Size size) { return cv::Mat1b(size, uint8_t{255}); };
  const cv::Size sizes[] = {{40, 30}, {2, 2}, {1, 1}, {1, 9}};
  for (const cv::Size size : sizes) {
    CAPTURE(size.width);
    CHECK(StrongestCorners(cv::Mat1b(size, uint8_t{70}), {all(size), 10, 0.01, 3.0}).empty());
  }
  const cv::Mat1b grey = Photograph({60, 40}, 1);
  CHECK(StrongestCorners(grey, {cv::Mat1b(grey.size(), uint8_t{0}), 10, 0.01, 3.0}).empty());
}

}  // namespace
}  // namespace freelsd
