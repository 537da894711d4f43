#include "api/export/png.h"

#include <doctest/doctest.h>
#include <opencv2/imgcodecs.hpp>

namespace freelsd {
namespace {

TEST_CASE("PNG: another reader finds the same pixels") {
  cv::Mat4b picture(7, 13, cv::Vec4b(1, 2, 3, 255));
  picture(3, 4) = cv::Vec4b(200, 100, 50, 0);
  cv::Mat3b opaque;
  cv::Mat(40, 60, CV_8UC3, cv::Scalar(9, 8, 7)).copyTo(opaque);
  opaque(1, 0) = cv::Vec3b(255, 0, 128);
  // Rows that do not follow one another in memory.
  const cv::Mat part = opaque(cv::Rect(0, 0, 31, 40));
  for (const cv::Mat& image : {cv::Mat(picture), cv::Mat(opaque), part}) {
    const std::string bytes = EncodePng(image);
    const std::vector<uint8_t> buffer(bytes.begin(), bytes.end());
    const cv::Mat read = cv::imdecode(buffer, cv::IMREAD_UNCHANGED);
    REQUIRE(read.type() == image.type());
    CHECK(cv::norm(read, image, cv::NORM_INF) == 0.0);
  }
}

TEST_CASE("PNG: the quick form and the form with a palette have the same pixels") {
  cv::Mat4b picture(60, 70);
  cv::randu(picture, 0, 256);
  for (const cv::Mat4b& image : {picture, cv::Mat4b(picture(cv::Rect(3, 5, 20, 30)))}) {
    const std::string bytes = EncodePngQuickly(image);
    const cv::Mat read =
        cv::imdecode(std::vector<uint8_t>(bytes.begin(), bytes.end()), cv::IMREAD_UNCHANGED);
    REQUIRE(read.type() == CV_8UC4);
    CHECK(cv::norm(read, image, cv::NORM_INF) == 0.0);
  }
  for (cv::Vec4b& pixel : picture) pixel[3] = 255;
  const std::string opaque = EncodePngQuickly(picture);
  const cv::Mat3b read =
      cv::imdecode(std::vector<uint8_t>(opaque.begin(), opaque.end()), cv::IMREAD_UNCHANGED);
  REQUIRE(read.size() == picture.size());
  CHECK(read(7, 9) == cv::Vec3b(picture(7, 9)[0], picture(7, 9)[1], picture(7, 9)[2]));
  std::array<cv::Vec4b, 256> palette;
  for (int i = 0; i < 256; ++i) palette[i] = picture(i / 70, i % 70);
  palette[0] = {1, 2, 3, 0};
  cv::Mat1b indices(30, 40);
  cv::randu(indices, 0, 256);
  const std::string small = EncodePalettePng(indices, palette);
  const cv::Mat4b colors =
      cv::imdecode(std::vector<uint8_t>(small.begin(), small.end()), cv::IMREAD_UNCHANGED);
  for (int row = 0; row < indices.rows; ++row) {
    for (int col = 0; col < indices.cols; ++col) {
      REQUIRE(colors(row, col) == palette[indices(row, col)]);
    }
  }
}

TEST_CASE("PNG: nothing, and what is not 8 bit colour, is refused") {
  CHECK_THROWS_AS(EncodePng(cv::Mat()), std::invalid_argument);
  CHECK_THROWS_AS(EncodePng(cv::Mat1b(4, 4)), std::invalid_argument);
  CHECK_THROWS_AS(EncodePngQuickly(cv::Mat4b()), std::invalid_argument);
  CHECK_THROWS_AS(EncodePalettePng(cv::Mat1b(), {}), std::invalid_argument);
  CHECK_THROWS_AS(EncodePng(cv::Mat(4, 4, CV_32FC3)), std::invalid_argument);
}

}  // namespace
}  // namespace freelsd
