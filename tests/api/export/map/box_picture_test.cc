#include <doctest/doctest.h>
#include <opencv2/imgcodecs.hpp>

#include "api/export/map/map.h"
#include "tests/api/export/layers/hill_map.h"

namespace freelsd {
namespace {

const LocalFrame kFrame({47.4, 8.55, 450.0});
// 20 m wider than the hill's map.
const WorldBox kBox{{-50.0, -40.0}, {70.0, 60.0}};

cv::Mat Decoded(const std::string& bytes) {
  cv::Mat picture =
      cv::imdecode(std::vector<char>(bytes.begin(), bytes.end()), cv::IMREAD_UNCHANGED);
  REQUIRE(!picture.empty());
  return picture;
}

cv::Mat4b HazardOf(double pixel_size_m, Backdrop backdrop) {
  cv::Mat picture = Decoded(HazardBoxPng(kBox, pixel_size_m, {{HillMap(), {}}}, backdrop, kFrame));
  REQUIRE(picture.channels() == 4);
  return picture;
}

TEST_CASE("box picture: each cell of the hazard is where it lies, and nothing is beyond the map") {
  const cv::Mat4b picture = HazardOf(0.5, Backdrop::kNone);
  CHECK(picture.size() == cv::Size(240, 200));
  const SiteMap map = HillMap();
  for (int row = 0; row < kHillRows; ++row) {
    for (int col = 0; col < kHillCols; ++col) {
      // A pixel inside the cell: those at its edges touch its neighbours too.
      const cv::Vec4b& pixel = picture(2 * (row + 20) + 1, 2 * (col + 20) + 1);
      const bool is_grey = pixel[0] == pixel[1] && pixel[1] == pixel[2];
      const bool is_green = pixel[1] > pixel[0] && pixel[1] > pixel[2];
      const uint8_t hazard = map.layers.hazard(row, col);
      CHECK(pixel[3] == 255);
      if (hazard == kUnseen) CHECK((is_grey || (!is_green && pixel[2] > pixel[0])));
      if (hazard == kHazard) CHECK((pixel[2] > pixel[1] && pixel[2] > pixel[0]));
      if (is_green) CHECK(hazard == kFree);
    }
  }
  CHECK(picture(5, 5)[3] == 0);
  CHECK(picture(195, 235)[3] == 0);
}

TEST_CASE("box picture: a photograph is seen through the hazard") {
  const cv::Mat4b picture = HazardOf(1.0, Backdrop::kPhoto);
  for (const cv::Vec4b& pixel : picture) CHECK(pixel[3] < 255);
}

TEST_CASE("box picture: the photograph fills its part of the box, the rest is white") {
  PhotoWindow window;
  window.grid = {{-50.0, 60.0}, 1.0, 50, 60};
  window.pixels = cv::Mat4b(50, 60, cv::Vec4b(200, 20, 20, 255));
  const cv::Mat3b picture = Decoded(PhotoBoxJpeg(kBox, 1.0, {window}, kFrame));
  CHECK(picture.size() == cv::Size(120, 100));
  CHECK(cv::norm(picture(20, 20), cv::Vec3b(200, 20, 20)) < 12.0);
  CHECK(cv::norm(picture(80, 100), cv::Vec3b(255, 255, 255)) < 12.0);
}

TEST_CASE(
    "box picture: a layer is transparent where it has no value, and an empty box is refused") {
  MapWindow window{HillMap(), {}};
  window.coverage = cv::Mat1b(kHillRows, kHillCols, uchar{3});
  window.coverage(cv::Rect(0, 50, 10, 10)).setTo(0);
  const cv::Mat4b picture =
      Decoded(LayerBoxPng("coverage", kBox, 1.0, {window}, {0.0, 6.0}, kFrame));
  CHECK(picture(75, 22)[3] == 0);
  CHECK(picture(30, 50)[3] == 255);
  CHECK_THROWS_AS(PhotoBoxJpeg({}, 1.0, {}, kFrame), std::invalid_argument);
}

}  // namespace
}  // namespace freelsd
