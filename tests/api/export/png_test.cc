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

TEST_CASE("PNG: nothing, and what is not 8 bit colour, is refused") {
  CHECK_THROWS_AS(EncodePng(cv::Mat()), std::invalid_argument);
  CHECK_THROWS_AS(EncodePng(cv::Mat1b(4, 4)), std::invalid_argument);
  CHECK_THROWS_AS(EncodePng(cv::Mat(4, 4, CV_32FC3)), std::invalid_argument);
}

}  // namespace
}  // namespace freelsd
