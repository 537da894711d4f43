#include "engine/segmentation/area_resize.h"

#include <doctest/doctest.h>
#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

TEST_CASE("area resize: OpenCV's result within one grey level, and the same nearly everywhere") {
  cv::RNG random(3);
  for (const int type : {CV_8UC1, CV_8UC3}) {
    cv::Mat image(481, 752, type);
    random.fill(image, cv::RNG::UNIFORM, 0, 256);
    for (const cv::Size size : {cv::Size(538, 344), {269, 172}, {752, 481}, {376, 241}, {8, 9}}) {
      cv::Mat expected;
      cv::resize(image, expected, size, 0.0, 0.0, cv::INTER_AREA);
      const cv::Mat reduced = ReduceByArea(image, size);
      REQUIRE(reduced.size() == expected.size());
      REQUIRE(reduced.type() == type);
      CHECK(cv::norm(reduced, expected, cv::NORM_INF) <= 1.0);
      const double share = cv::norm(reduced, expected, cv::NORM_L1) /
                           static_cast<double>(reduced.total() * reduced.elemSize());
      constexpr double kMaxShareOfOtherRounding = 1e-3;
      CHECK(share < kMaxShareOfOtherRounding);
    }
  }
}

TEST_CASE("area resize: an image that is part of a larger one is read by its own rows") {
  cv::Mat3b large(60, 80);
  cv::RNG(4).fill(large, cv::RNG::UNIFORM, 0, 256);
  const cv::Rect part(11, 7, 50, 40);
  const cv::Mat reduced = ReduceByArea(large(part), {31, 25});
  CHECK(cv::norm(reduced, ReduceByArea(large(part).clone(), {31, 25}), cv::NORM_INF) == 0.0);
}

}  // namespace
}  // namespace freelsd
