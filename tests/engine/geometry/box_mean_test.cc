#include "engine/geometry/box_mean.h"

#include <utility>

#include <doctest/doctest.h>
#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

cv::Mat1f Noise(cv::Size size) {
  cv::Mat1f noise(size);
  cv::RNG(7).fill(noise, cv::RNG::UNIFORM, 0.0, 1.0);
  return noise;
}

// Cell by cell, of a raster that has `half` cells more on every side.
double PlainSum(const cv::Mat1f& widened, const cv::Point& cell, int half) {
  return cv::sum(widened({cell.x, cell.y, 2 * half + 1, 2 * half + 1}))[0];
}

TEST_CASE("box mean: the mean of the square about each cell, with either border") {
  const cv::Mat1f values = Noise({17, 11});
  constexpr int kSide = 5, kHalf = 2;
  const std::pair<BoxBorder, int> borders[] = {{BoxBorder::kNothing, cv::BORDER_CONSTANT},
                                               {BoxBorder::kMirrored, cv::BORDER_REFLECT_101}};
  for (const auto& [border, type] : borders) {
    cv::Mat1f widened;
    cv::copyMakeBorder(values, widened, kHalf, kHalf, kHalf, kHalf, type);
    const cv::Mat1f mean = BoxMean(values, kSide, border);
    for (int row = 0; row < values.rows; ++row) {
      for (int col = 0; col < values.cols; ++col) {
        const double expected = PlainSum(widened, {col, row}, kHalf) / (kSide * kSide);
        REQUIRE(mean(row, col) == doctest::Approx(expected).epsilon(1e-6));
      }
    }
  }
}

TEST_CASE("box sum: whole numbers stay whole, and nothing lies beyond the edge") {
  const cv::Mat1d ones(9, 13, 1.0);
  const cv::Mat1d sum = BoxSum(ones, 7);
  CHECK(sum(4, 6) == 49.0);
  CHECK(sum(0, 0) == 16.0);
  CHECK(sum(8, 6) == 28.0);
}

TEST_CASE("box side: the odd number nearest to the width") {
  CHECK(BoxSide(0.4) == 1);
  CHECK(BoxSide(3.0) == 3);
  CHECK(BoxSide(3.9) == 3);
  CHECK(BoxSide(4.1) == 5);
}

}  // namespace
}  // namespace freelsd
